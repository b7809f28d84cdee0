#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hardware/devices/device.h"
#include "hardware/safety/governor_types.h"

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
  explicit MotionState(std::size_t joints = 0)
      : position(joints), velocity(joints), target(joints), command(joints), residual(joints) {}

  // === The governor
  safety::GovernorState state = safety::GovernorState::kDisconnected;
  safety::FaultCause fault = safety::FaultCause::kNone;
  safety::HoldCause hold = safety::HoldCause::kNone;
  safety::StopMode stop_mode = safety::StopMode::kBrake;
  bool is_slow = false;
  std::uint64_t stream = 0;  ///< of the newest accepted pose; 0: none yet

  // === The device
  devices::Fault device_fault;  ///< as it was when `fault` was latched
  bool guard_failed = false;    ///< the last assertion on motor angles
  bool is_connected = false;
  bool is_powered = false;
  bool is_homed = false;
  bool is_homing = false;
  double temperature_c = -1;  ///< the hottest motor; -1: not told
  devices::DeviceCounters counters;
  FixedText trouble;  ///< why the device is not open, not armed, not homed; empty: nothing

  // === The pose: rad, one per joint; empty vectors never
  devices::TimePoint measured_at{};
  std::vector<double> position;
  std::vector<double> velocity;  ///< rad/s; NaN where it is not known
  std::vector<double> target;    ///< the newest accepted pose inside the limits
  std::vector<double> command;   ///< sent in this period; the measured pose without power
  std::vector<double> residual;  ///< of it, what the hand cannot follow
  double tracking = 0;           ///< the largest |command - position| under power
  std::optional<devices::Duration> command_age;  ///< of the newest accepted pose
  std::optional<devices::Duration> stream_age;   ///< since the stream was known to live

  // === Counts since the start
  std::uint64_t poses_accepted = 0;
  std::uint64_t poses_refused = 0;
  std::uint64_t refusals = 0;  ///< of poses and requests
  FixedText last_refusal;
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
