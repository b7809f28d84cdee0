#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hardware/devices/device.h"
#include "hardware/safety/governor_types.h"
#include "idl/hardware.h"

namespace handgraft::bridge {

/// A text of bounded length, which is copied without allocating.
class FixedText {
 public:
  void set(std::string_view text) {
    size_ = std::min(text.size(), chars_.size());
    std::copy_n(text.begin(), size_, chars_.begin());
  }

  [[nodiscard]] std::string_view view() const { return {chars_.data(), size_}; }

 private:
  std::array<char, 240> chars_{};
  std::size_t size_ = 0;
};

/// All that there is to tell of a hand in motion, once a period. Copying one onto another of
/// the same hand allocates nothing.
struct MotionState {
  explicit MotionState(std::size_t joints = 0, std::size_t motors = 0, std::size_t touches = 0)
      : position(joints),
        velocity(joints),
        target(joints),
        command(joints),
        residual(joints),
        effort(joints, std::numeric_limits<double>::quiet_NaN()),
        motor_current(motors),
        motor_temperature(motors),
        touch(touches) {}

  // === The governor
  safety::GovernorState state = safety::GovernorState::kDisconnected;
  safety::FaultCause fault = safety::FaultCause::kNone;
  safety::HoldCause hold = safety::HoldCause::kNone;
  safety::StopMode stop_mode = safety::StopMode::kBrake;
  bool is_slow = false;
  bool is_guided = false;      ///< by timed samples
  std::uint64_t stream = 0;    ///< of the newest accepted pose; 0: none yet
  std::uint64_t sequence = 0;  ///< its number
  double behind_s = 0;         ///< the samples' clock, behind where it is meant to be
  FixedText slower;  ///< the joint because of which samples are followed slower; empty: none
  std::uint64_t samples_skipped = 0;  ///< since the start
  FixedText held;                     ///< which motor is held back, and why; empty: none

  // === The device
  devices::Fault device_fault;  ///< as it was when `fault` was latched
  FixedText fault_text;         ///< of it: motor, joint, and what the device says, in words
  bool guard_failed = false;    ///< the last assertion on motor angles
  bool is_connected = false;
  bool is_powered = false;
  bool is_homed = false;
  bool needs_homing = false;  ///< HOME finds its zeros; else `bridge check` does
  bool is_homing = false;
  double temperature_c = -1;  ///< the hottest motor; -1: not told
  devices::DeviceCounters counters;
  FixedText zeros;    ///< why the zeros are not known; empty: they are, or were never found
  FixedText trouble;  ///< why the device is not open, not armed, not homed; empty: nothing

  // === The pose: rad, m of joints that slide, one per joint; empty vectors never
  devices::TimePoint measured_at{};
  std::vector<double> position;
  std::vector<double> velocity;  ///< a second; NaN where it is not known
  std::vector<double> target;    ///< the newest accepted pose inside the limits
  std::vector<double> command;   ///< sent in this period; the measured pose without power
  std::vector<double> residual;  ///< of it, what the hand cannot follow
  /// Of joints with a motor of their own: its current times its `torque_Nm_A`, Nm, or N of
  /// those that slide; NaN else.
  std::vector<double> effort;
  std::vector<double> motor_current;      ///< A, in the motors' directions; NaN: not told
  std::vector<double> motor_temperature;  ///< degrees Celsius; NaN: not told
  std::vector<double> touch;              ///< N
  /// The largest |command - position| under power, and the largest residual; of joints that
  /// slide, at the motor.
  double tracking_rad = 0, residual_rad = 0;
  bool is_at_target = false;
  std::optional<devices::Duration> command_age;  ///< of the newest accepted pose
  std::optional<devices::Duration> stream_age;   ///< since the stream was known to live

  // === Counts since the start
  std::uint64_t poses_accepted = 0;
  std::uint64_t poses_refused = 0;
  std::uint64_t refusals = 0;  ///< of poses and requests
  FixedText last_refusal;
  v1::BridgeRefusal refusal = v1::REFUSAL_NONE;
  FixedText clamping;      ///< of the newest pose: which joints, asked and given; empty: none
  double clamped_rad = 0;  ///< by how much at most; at the motor, of joints that slide
  std::uint64_t clamped = 0;  ///< periods in which the target lay outside the limits
  std::uint64_t limited = 0;  ///< periods in which velocity or acceleration were cut

  // === The loop
  std::uint64_t periods = 0;
  std::uint64_t overruns = 0;
  devices::Duration worst_lateness{};
  bool is_realtime = false;
};

/// Why the hand is in its state, for people: "armed", "held: the stream is stale", "fault:
/// motor 3: no answer; RESET clears it".
std::string describe(const MotionState& state);

}  // namespace handgraft::bridge
