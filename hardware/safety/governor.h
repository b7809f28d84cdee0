#pragma once

#include <optional>
#include <vector>

#include "hardware/safety/governor_types.h"
#include "hardware/safety/joint_limiter.h"
#include "hardware/safety/output_guard.h"
#include "hardware/safety/stream_watch.h"

namespace handgraft::safety {

/// Stands between a stream of poses and motors: decides when motors have power, and makes every
/// position that leaves keep every limit. A state machine without wires, threads or a clock:
/// requests and poses go in, `tick` advances by one period and says what the device is to do.
///
/// What holds, whatever comes in:
/// - power goes on only by `arm`, never by a pose, a reset or a device that comes back;
/// - after a stale stream, a fault or an emergency stop nothing moves on before the next `arm`;
/// - kFault and kEStop are left by `reset` alone, and a reset gives no power;
/// - positions are finite, inside the limits, with velocity, acceleration and jerk within
///   theirs (1e-6 relative): the limiter sees to it and an independent guard asserts it.
///
/// A far pose is gone to slowly: the first one after `arm`, and each that is a long step from a
/// hand at rest, or from the pose before.
///
/// Power goes on where the hand is: until the device reports power, what is sent is the
/// measured pose. Late ticks are not made up for.
///
/// Copyable, so that tests can try every continuation. Not thread-safe. No call after the
/// constructor allocates, locks, logs or throws, save BrokenContract.
class Governor {
 public:
  /// Errors: InvalidInput for bad names or limits, times that are not positive, a joint that
  /// cannot stand still within `brake_within`.
  explicit Governor(GovernorOptions options);

  // === What comes in

  /// A pose to follow; the newest that is accepted wins. Another stream than the one followed
  /// makes an armed hand hold.
  SampleVerdict offer(const TargetSample& sample, Time now);

  /// The stream's pose moves on along timed samples (`StreamWatch::guide`); begins no stream.
  bool guide(std::uint64_t stream, std::span<const double> joint_rad, Time sampled);

  /// The stream says that its newest pose still stands (`StreamWatch::renew`).
  void renew(std::uint64_t stream, Time now);

  /// Gives power and follows the stream, from kIdle or kHolding. Call it for a request's first
  /// arrival only. When the newest pose is not near the measured one, motion is slow until it
  /// is.
  Refusal arm(Time now);

  /// Decelerates, then power off.
  void disarm();

  /// Overrides everything. Latched.
  void estop();

  /// Acknowledges kFault or kEStop; the device is told to clear its faults. kIdle follows once
  /// the cause is gone, or the latch stays.
  Refusal reset();

  /// The device confirmed, after the last tick's order, that its motors are off: who asks next
  /// need not wait for a period to be told so.
  void noteMotorsOff() { device_reports_power_ = device_reports_power_ && wants_power_; }

  /// One period. `now` must not run backwards.
  MotorOrder tick(const DeviceReport& device, Time now);

  // === What may be told

  [[nodiscard]] GovernorState state() const { return state_; }

  /// Of the latched fault, also under an emergency stop; the device's code beside.
  [[nodiscard]] FaultCause fault() const { return fault_; }

  [[nodiscard]] std::uint32_t faultCode() const { return fault_code_; }

  [[nodiscard]] HoldCause hold() const { return hold_; }

  /// True while motion is slow because the first target was not near.
  [[nodiscard]] bool isRamping() const { return ramping_; }

  [[nodiscard]] const GovernorCounters& counters() const { return counters_; }

  /// Of the newest accepted pose; empty before the first.
  [[nodiscard]] std::optional<Time::duration> commandAge(Time now) const {
    return stream_.age(now);
  }

  /// The newest accepted pose inside the limits, rad; zeros before the first.
  [[nodiscard]] const std::vector<double>& target() const { return target_; }

  /// The same as it was asked for.
  [[nodiscard]] const std::vector<double>& asked() const { return stream_.target(); }

  /// What was sent last, rad; meaningful under power.
  [[nodiscard]] std::span<const double> commanded() const { return limiter_.positions(); }

 private:
  void takeTarget();
  void noteTime(Time now);
  void noteDevice(const DeviceReport& device, Time now);
  void watchConnection(const DeviceReport& device, Time now);
  void watchPower(const DeviceReport& device, Time now);
  void watchMotors(const DeviceReport& device, Time now);
  [[nodiscard]] bool measuredIsUsable(const DeviceReport& device) const;
  [[nodiscard]] bool isFarOutside() const;
  [[nodiscard]] Refusal armRefusal(Time now) const;
  [[nodiscard]] bool isNearTarget(std::span<const double> positions) const;
  [[nodiscard]] bool isFarStep() const;

  void enterFault(FaultCause cause);
  void enterHold(HoldCause cause);
  void finishReset(Time now);
  void switchOff();
  MotorOrder orderUnderPower(Time now);
  void follow();
  [[nodiscard]] Power powerless() const;

  GovernorOptions options_;
  StreamWatch stream_;
  JointLimiter limiter_;
  OutputGuard guard_;
  GovernorCounters counters_;

  GovernorState state_ = GovernorState::kDisconnected;
  FaultCause fault_ = FaultCause::kNone;
  std::uint32_t fault_code_ = 0;
  HoldCause hold_ = HoldCause::kNone;
  bool ramping_ = false;
  bool aim_anew_ = false;       // the limiter has yet to be told of target_
  bool clear_faults_ = false;   // in the next order
  std::vector<double> target_;  // inside the limits

  bool wants_power_ = false;              // what the last order said, or the next will
  bool has_power_ = false;                // the device confirmed it since the order
  std::optional<Time> power_changed_at_;  // first tick with the present wants_power_
  std::optional<Time> stopping_since_;    // first tick of a hold or an emergency stop
  std::optional<Time> resetting_since_;
  std::optional<Time> limited_since_;
  bool is_resetting_ = false;

  std::vector<double> measured_;
  Time measured_at_{};
  bool is_measured_ = false;  // measured_ is a pose, of a device that is there
  bool is_connected_ = false;
  bool device_reports_power_ = false;
  bool device_reports_fault_ = false;
  bool motors_outside_ = false;
  bool must_cut_ = false;  // power went off by an order that may not have arrived
  std::optional<Time> last_tick_;
  unsigned overruns_in_a_row_ = 0;
};

}  // namespace handgraft::safety
