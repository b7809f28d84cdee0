#pragma once

#include <memory>
#include <vector>

#include "hardware/config/hand_config.h"

#include "tests/hardware/emulators/ability_hand_emulator.h"
#include "tests/hardware/emulators/allegro_emulator.h"
#include "tests/hardware/emulators/dynamixel_emulator.h"
#include "tests/hardware/emulators/inspire_emulator.h"
#include "tests/hardware/emulators/odrive_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::test {

/// The device that a config tells, emulated, at the end of a wire. Angles are those of the
/// config's motors, read off the device itself.
class HandRig {
 public:
  virtual ~HandRig() = default;

  virtual EmulatedDevice& emulated() = 0;
  virtual Wire& wire() = 0;

  /// rad: where motor `i` stands, and where it was told to go.
  virtual double angle(std::size_t i) = 0;
  virtual double goal(std::size_t i) = 0;

  /// Turns a motor that is off by hand, rad; one that holds stays.
  void put(std::size_t i, double angle_rad) {
    if (!isPowered()) turn(i, angle_rad);
  }

  /// rad: one unit of the device; of a float, what it can tell of a few turns.
  [[nodiscard]] virtual double unit(std::size_t i) const = 0;
  /// Whether any motor would move by itself or hold.
  virtual bool isPowered() = 0;
  /// An error that the device tells, until `heal`.
  virtual void breakDown() = 0;
  virtual void heal() = 0;

 protected:
  virtual void turn(std::size_t i, double angle_rad) = 0;
};

/// `watchdog` of the device itself; 0: as the config says.
std::unique_ptr<HandRig> makeHandRig(const config::HandConfig& config,
                                     bool on_a_pty = false,
                                     Duration watchdog = {});

/// The axes behind the adapter of an ODrive hand.
ODriveEmulator& busOf(HandRig& odrive_rig);

/// The hand behind the adapter of an Allegro.
AllegroEmulator& allegroOf(HandRig& allegro_rig);

/// Lines of an ODrive hand that is not homed: each drum has to wind in by some turns before its
/// line is taut. Returns the shafts' places there, rad: what homing ought to find.
std::vector<double> slackenLines(HandRig& odrive_rig, const config::HandConfig& config);

/// The zeros that `homed` tells, rad of the shafts: without what their encoders count from.
std::vector<double> zerosOfShafts(HandRig& odrive_rig, const config::HandConfig& homed);

}  // namespace handgraft::test
