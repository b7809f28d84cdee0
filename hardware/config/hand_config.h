#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/config/device_kinds.h"
#include "hardware/safety/governor_types.h"
#include "hardware/safety/homing_run.h"
#include "hardware/tendon/motor_map.h"
#include "hardware/tendon/synergy_map.h"
#include "hardware/tendon/tendon_hand.h"

namespace handgraft::config {

enum class CanCarrier { kSlcan, kSocketCan };
enum class ODriveFirmware { k05, k06 };

/// The device and its wire. What its kind has no use for keeps its default.
struct DeviceConfig {
  DeviceKind kind = DeviceKind::kSimulated;
  std::string port;           ///< a tty; the interface's name for SocketCAN
  int baud = 0;               ///< of the tty
  bool is_baud_told = false;  ///< else the rate is a number alone, as of USB adapters
  CanCarrier carrier = CanCarrier::kSlcan;
  int can_bitrate = 500'000;
  ODriveFirmware firmware = ODriveFirmware::k06;
  int address = 0x50;  ///< of an Ability Hand
  std::chrono::milliseconds watchdog{
      100};                ///< the device's own deadman, of those that have one
  double force_N = 3;      ///< of an Inspire hand: where a finger stops
  double stiffness = 0.6;  ///< Nm/rad, of an Allegro's position loop, which is ours
  double damping = 0.02;   ///< Nm s/rad
  double torque = 0.3;     ///< Nm, the most of each of its motors
  /// Of the device itself: what bytes take on a tty at its rate comes on top.
  std::chrono::milliseconds reply_timeout{5};
  int tolerated_misses = 3;  ///< answers in a row
  bool touch = false;        ///< of an Ability Hand: tell what it feels, in place of velocities
};

/// An incremental one counts from wherever it is switched on: its zero is found by homing, and
/// lost with its power. Unsaid, motors that are homed have such a one, and no others.
enum class Encoder { kUnsaid, kAbsolute, kIncremental };

/// Of a Dynamixel's position loop, in the motor's own units.
struct MotorGains {
  int p = 0, i = 0, d = 0;
};

/// One motor, in the order of the transmission's motors.
struct MotorConfig {
  std::string name;
  std::string joint;        ///< that it moves, of direct drive; empty: of its place in the list
  int id = 0;               ///< Dynamixel id, ODrive node, or place among a hand's own motors
  double gear = 1;          ///< turns of the device's encoder per turn of the motor
  int direction = 1;        ///< -1: the device counts the other way
  double zero_rad = 0;      ///< the device's angle, at its encoder, where the motor's is 0
  tendon::Range range_rad;  ///< that it may be sent to
  double velocity_rad_s = 0;  ///< the most that it may be asked for
  double current_A = 0;       ///< that it may use
  Encoder encoder = Encoder::kUnsaid;
  std::optional<double> torque_Nm_A;  ///< at the motor's angle; unsaid: efforts are told in A
  std::optional<MotorGains> gains;
  /// Since it was homed the device counts from a place of ours, so that a restart shows.
  bool is_marked = false;
};

/// A postural synergy: q = rest + column * s.
struct SynergyConfig {
  std::vector<double> column;  ///< one entry per joint
};

enum class TransmissionKind { kDirect, kSynergies, kTendons };

/// What lies between joints and motors. Mimic joints are direct drive with followers.
struct TransmissionConfig {
  TransmissionKind kind = TransmissionKind::kDirect;
  std::vector<tendon::MimicJoint> followers;  ///< direct
  std::vector<SynergyConfig> synergies;       ///< one per motor
  std::vector<double> rest_rad;               ///< synergies: one per joint
  tendon::TendonHand tendons;                 ///< one tendon per motor
};

/// Everything about one hand that the bridge must know before anything moves.
struct HandConfig {
  std::string hand;
  DeviceConfig device;
  safety::GovernorOptions governor;  ///< names and limits of the joints included
  int realtime_priority = 0;         ///< 1 to 99: SCHED_FIFO, where permitted
  TransmissionConfig transmission;
  std::vector<MotorConfig> motors;
  double motor_outside_rad = 0.2;  ///< beyond its range: a motor's zero is wrong
  double hot_c = 65;               ///< a motor so hot is held back
  /// A motor that pushes as hard as it may for so long, and stands, is held back.
  std::chrono::milliseconds stalled_for{10'000};
  std::vector<safety::HomingStep> homing;  ///< in this order
  std::filesystem::path calibration;       ///< empty: none; relative to the config's folder
  bool is_calibrated = false;              ///< the calibration was there and read

  [[nodiscard]] std::size_t jointCount() const { return governor.names.size(); }
};

/// The hand's way from joints to motors. Errors: InvalidInput.
std::unique_ptr<tendon::MotorMap> makeMotorMap(const HandConfig& config);

/// Of direct drive, the joints that have motors, in the order of the motors; else none.
std::vector<std::string> motorJoints(const HandConfig& config);

/// What is hardly meant though it may be: joints and motors that go round more often than those
/// of a hand, as angles in degrees do. Empty if nothing.
std::vector<std::string> remarksOn(const HandConfig& config);

/// What there is to object to in `config` as a whole: that motors can go where and as fast as
/// joints may ask, that the governor and the transmission accept it, that watchdogs and gaps
/// fit each other and the device, that ids are the device's. Empty if nothing.
///
/// `known` is what is wrong already, each with its key first: what depends on those keys is not
/// looked at, since a value that stands in for a wrong one proves nothing.
std::vector<std::string> problemsOf(const HandConfig& config,
                                    const std::vector<std::string>& known = {});

}  // namespace handgraft::config
