#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "hardware/safety/governor.h"

namespace handgraft::safety::test {

using namespace std::chrono_literals;

/// Two joints that brake within a few periods, so that tests of states stay short.
inline GovernorOptions quickOptions() {
  const JointLimits limits{
      .lower = -1, .upper = 1.5, .velocity = 1, .acceleration = 50, .jerk = 5000};
  GovernorOptions options;
  options.names = {"thumb", "index"};
  options.limits = {limits, limits};
  options.period_s = 0.01;
  options.stale_after = 35ms;
  options.hold_for = 60ms;
  options.brake_within = 100ms;
  options.device_silent_after = 25ms;
  options.power_within = 50ms;
  options.reset_within = 40ms;
  options.limited_for = 20ms;
  options.longest_gap = 30ms;
  options.overruns_in_a_row = 5;
  return options;
}

/// A governor, a stream and a hand that does as it is told, in virtual time. Copyable.
class Rig {
 public:
  explicit Rig(GovernorOptions options = quickOptions())
      : governor(options),
        period(std::chrono::duration_cast<Time::duration>(
            std::chrono::duration<double>(options.period_s))),
        names(options.names),
        position(options.names.size()),
        pose(options.names.size(), 0.05) {}

  SampleVerdict offer(std::vector<double> joint_rad) {
    pose = std::move(joint_rad);
    return offer();
  }

  /// The newest pose under a new number.
  SampleVerdict offer() {
    ++sequence;
    return governor.offer({stream, sequence, 0, names, pose}, now);
  }

  Refusal arm() { return governor.arm(now); }

  /// One period later. The hand powers up and down a period after it is told, and follows.
  Power tick(Time::duration later = {}) {
    now += period + later;
    const Time measured_at = silent ? now - 1s : now;
    was_reported_on = reports_power;
    const MotorOrder order = governor.tick(
        {connected, reports_power, fault_code, limited, measured_at, position, motors_outside},
        now);
    power = order.power;
    sent.assign(order.positions.begin(), order.positions.end());
    if (order.clear_faults && clears_faults) fault_code = 0;
    if (!stuck) reports_power = order.power == Power::kOn;
    if (order.power == Power::kOn) position = sent;
    return power;
  }

  void tick(int count) {
    for (int i = 0; i < count; ++i)
      tick();
  }

  /// Periods with a live stream.
  void follow(int count) {
    for (int i = 0; i < count; ++i) {
      offer();
      tick();
    }
  }

  /// From the start to motors that follow a pose near zero.
  void armUp() {
    tick();
    follow(1);
    arm();
    follow(3);
  }

  [[nodiscard]] GovernorState state() const { return governor.state(); }

  Governor governor;
  Time::duration period;
  std::vector<std::string> names;
  Time now{1h};

  // The hand
  bool connected = true;
  bool silent = false;  ///< its measured state is old
  bool reports_power = false;
  bool was_reported_on = false;  ///< in the newest period
  bool stuck = false;            ///< power does not change
  bool limited = false;
  bool motors_outside = false;
  bool clears_faults = true;
  std::uint32_t fault_code = 0;
  std::vector<double> position;

  // The stream
  std::uint64_t stream = 1;
  std::uint64_t sequence = 0;
  std::vector<double> pose;

  // The newest order
  Power power = Power::kOff;
  std::vector<double> sent;
};

}  // namespace handgraft::safety::test
