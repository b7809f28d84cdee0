#pragma once

#include <memory>
#include <string>

#include "hardware/devices/device.h"

#include "tests/hardware/emulators/ability_hand_emulator.h"
#include "tests/hardware/emulators/allegro_emulator.h"
#include "tests/hardware/emulators/dynamixel_emulator.h"
#include "tests/hardware/emulators/inspire_emulator.h"
#include "tests/hardware/emulators/odrive_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::test {

/// A driver, a wire and the device that it drives, all kinds alike.
class Rig {
 public:
  virtual ~Rig() = default;

  virtual devices::Device& device() = 0;
  virtual EmulatedDevice& emulated() = 0;
  virtual Wire& wire() = 0;

  /// rad: how far a measured angle may be off; where the limits are.
  [[nodiscard]] virtual double unit() const = 0;
  [[nodiscard]] virtual double lower(std::size_t motor) const = 0;
  [[nodiscard]] virtual double upper(std::size_t motor) const = 0;
  /// How long the device goes on by itself; 0: for good.
  [[nodiscard]] virtual Duration watchdog() const = 0;
  [[nodiscard]] virtual devices::Fault::Kind watchdogFault() const = 0;

  /// rad, as it is, whatever the driver thinks.
  virtual double angle(std::size_t motor) = 0;
  /// Whether any motor would move by itself or hold.
  virtual bool isPowered() = 0;

  /// Messages that its own stop takes.
  [[nodiscard]] virtual std::size_t stopMessages() const { return 1; }

  /// A goal of long ago, far away.
  virtual void leaveStaleGoal() = 0;
  /// A hardware error that stays until `heal`.
  virtual void breakDown() = 0;
  virtual void heal() = 0;

  std::vector<double> angles();
  /// A place between the limits: 0 the lower, 1 the upper.
  std::vector<double> between(double share) const;
  [[nodiscard]] virtual std::size_t count() const = 0;
};

/// The last one is that of the example, hardware/devices/examples.
enum class RigKind {
  kDynamixel,
  kAbilityHand,
  kODrive06,
  kODrive05,
  kInspire,
  kAllegro,
  kLines
};
enum class WireKind { kVirtual, kPty };

std::unique_ptr<Rig> makeRig(RigKind kind, WireKind wire = WireKind::kVirtual);
std::string nameOf(RigKind kind);

}  // namespace handgraft::test
