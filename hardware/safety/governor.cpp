#include "hardware/safety/governor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::safety {

namespace {

constexpr double kLate = 1.5;  // periods between two ticks that count as an overrun

template <class Enum>
std::size_t indexOf(Enum value) {
  return static_cast<std::size_t>(value);
}

void requirePositive(const char* what, Milliseconds time) {
  if (time <= Milliseconds::zero()) rejectInput("{} {} ms is not positive", what, time.count());
}

void requireDistance(const char* what, const Distance& distance, bool may_be_none) {
  for (const double value : {distance.rad, distance.m}) {
    if (!(value > 0 || (may_be_none && value == 0)) || !std::isfinite(value))
      rejectInput("{} {} is not {} and finite", what, value,
                  may_be_none ? "0 or more" : "positive");
  }
}

GovernorOptions validated(GovernorOptions options) {
  if (options.names.size() != options.limits.size())
    rejectInput("{} joint names for {} limits", options.names.size(), options.limits.size());
  requirePositive("stale time", options.stale_after);
  requirePositive("hold time", options.hold_for);
  requirePositive("braking time", options.brake_within);
  requirePositive("device's silence", options.device_silent_after);
  requirePositive("time to power", options.power_within);
  requirePositive("time to reset", options.reset_within);
  requirePositive("time limited", options.limited_for);
  requirePositive("longest gap", options.longest_gap);
  requireDistance("near", options.near, true);
  if (!(options.ramp_share > 0) || !(options.ramp_share <= 1))
    rejectInput("ramp share {} is not in (0, 1]", options.ramp_share);
  requireDistance("step", options.step, false);
  requireDistance("outside", options.outside, false);
  for (std::size_t i = 0; i < options.names.size(); ++i) {
    const double travel = options.limits[i].travel;
    if (!(travel > 0) || !std::isfinite(travel))
      rejectInput("joint {}: travel {} is not in (0, inf)", quoted(options.names[i]), travel);
  }
  if (options.overruns_in_a_row == 0) rejectInput("overruns in a row must be at least 1");
  return options;
}

}  // namespace

Governor::Governor(GovernorOptions options)
    : options_(validated(std::move(options))),
      stream_(options_.names, options_.stale_after),
      limiter_(options_.limits, options_.period_s),
      guard_(options_.limits, options_.period_s),
      target_(options_.names.size()),
      measured_(options_.names.size()) {
  const double brake_s = std::chrono::duration<double>(options_.brake_within).count();
  for (std::size_t i = 0; i < options_.names.size(); ++i) {
    if (limiter_.brakingTime(i) > brake_s) {
      rejectInput("joint {}: needs {} s to stand still, more than the braking time {} s",
                  quoted(options_.names[i]), limiter_.brakingTime(i), brake_s);
    }
  }
}

// === Requests

SampleVerdict Governor::offer(const TargetSample& sample, Time now) {
  const std::optional<std::uint64_t> before = stream_.stream();
  const SampleVerdict verdict = stream_.see(sample, now);
  ++counters_.samples[indexOf(verdict)];
  if (verdict != SampleVerdict::kAccepted) return verdict;
  takeTarget();
  if (state_ == GovernorState::kArmed && before && *before != sample.stream)
    enterHold(HoldCause::kStreamChanged);
  return verdict;
}

bool Governor::guide(std::uint64_t stream, std::span<const double> joint_rad, Time sampled) {
  if (!stream_.guide(stream, joint_rad, sampled)) return false;
  takeTarget();
  return true;
}

void Governor::takeTarget() {
  bool is_clamped = false;
  for (std::size_t i = 0; i < target_.size(); ++i) {
    target_[i] = limiter_.allowed(i, stream_.target()[i]);
    is_clamped = is_clamped || target_[i] != stream_.target()[i];
  }
  if (is_clamped) ++counters_.clamped_samples;
  aim_anew_ = true;
}

void Governor::renew(std::uint64_t stream, Time now) {
  stream_.renew(stream, now);
}

Refusal Governor::armRefusal(Time now) const {
  if (state_ == GovernorState::kEStop) return Refusal::kEStop;
  if (state_ == GovernorState::kFault) return Refusal::kFault;
  if (!is_connected_) return Refusal::kNotConnected;
  if (!is_measured_ || now - measured_at_ > options_.device_silent_after)
    return Refusal::kNotMeasured;
  if (!stream_.isFresh(now)) return Refusal::kNoFreshStream;
  if (isFarOutside()) return Refusal::kOutOfRange;
  if (motors_outside_) return Refusal::kMotorsOutside;
  if (!wants_power_ && device_reports_power_) return Refusal::kMotorsOn;
  return Refusal::kNone;
}

Refusal Governor::arm(Time now) {
  const Refusal refusal = armRefusal(now);
  ++counters_.refusals[indexOf(refusal)];
  if (refusal != Refusal::kNone || state_ == GovernorState::kArmed) return refusal;
  if (state_ == GovernorState::kIdle) {
    wants_power_ = true;
    has_power_ = false;
    power_changed_at_.reset();
    limiter_.reset(measured_);
    guard_.reset(measured_);
  }
  state_ = GovernorState::kArmed;
  hold_ = HoldCause::kNone;
  stopping_since_.reset();
  limited_since_.reset();
  aim_anew_ = true;
  ramping_ = !isNearTarget(measured_);
  return refusal;
}

void Governor::disarm() {
  if (state_ == GovernorState::kArmed) enterHold(HoldCause::kDisarmed);
  if (state_ == GovernorState::kHolding) hold_ = HoldCause::kDisarmed;
}

void Governor::estop() {
  is_resetting_ = false;
  if (state_ == GovernorState::kEStop) return;
  ++counters_.emergency_stops;
  state_ = GovernorState::kEStop;
  hold_ = HoldCause::kNone;
  ramping_ = false;
  stopping_since_.reset();
  const bool brakes = options_.stop_mode == StopMode::kBrake && wants_power_ && has_power_;
  if (brakes) {
    limiter_.brake();
  } else {
    switchOff();
  }
  // Who cannot be heard cannot be braked.
  if (!is_connected_) must_cut_ = true;
}

Refusal Governor::reset() {
  if (state_ != GovernorState::kFault && state_ != GovernorState::kEStop)
    return Refusal::kNothingToReset;
  if (wants_power_ || device_reports_power_) return Refusal::kMotorsOn;
  is_resetting_ = true;
  resetting_since_.reset();
  clear_faults_ = true;
  return Refusal::kNone;
}

// === Changes of state

void Governor::switchOff() {
  if (wants_power_) power_changed_at_.reset();
  wants_power_ = false;
  has_power_ = false;
  ramping_ = false;
  stopping_since_.reset();
}

void Governor::enterFault(FaultCause cause) {
  const bool is_new = fault_ == FaultCause::kNone;
  is_resetting_ = false;
  if (cause == FaultCause::kStaysOn || (wants_power_ && (cause == FaultCause::kDeviceLost ||
                                                         cause == FaultCause::kDeviceSilent)))
    must_cut_ = true;
  switchOff();
  if (state_ != GovernorState::kEStop) state_ = GovernorState::kFault;
  hold_ = HoldCause::kNone;
  if (!is_new) return;  // the first cause is the one to tell
  fault_ = cause;
  ++counters_.faults[indexOf(cause)];
}

void Governor::enterHold(HoldCause cause) {
  hold_ = cause;
  if (!has_power_) {
    switchOff();
    state_ = GovernorState::kIdle;
    return;
  }
  state_ = GovernorState::kHolding;
  stopping_since_.reset();
  limiter_.brake();
}

// === One period

MotorOrder Governor::tick(const DeviceReport& device, Time now) {
  ++counters_.ticks;
  noteTime(now);
  noteDevice(device, now);
  finishReset(now);
  if (!stream_.isFresh(now)) {
    stream_.forgetClock();
    if (state_ == GovernorState::kArmed) {
      ++counters_.stale_streams;
      enterHold(HoldCause::kStale);
    }
  }
  MotorOrder order;
  if (wants_power_) order = orderUnderPower(now);
  if (!wants_power_) order = {powerless(), false, {}};
  if (!power_changed_at_) power_changed_at_ = now;
  order.clear_faults = std::exchange(clear_faults_, false);
  return order;
}

void Governor::noteTime(Time now) {
  if (last_tick_) {
    HANDGRAFT_REQUIRE(now >= *last_tick_);
    const Time::duration gap = now - *last_tick_;
    counters_.longest_gap = std::max(counters_.longest_gap, gap);
    const bool is_late = std::chrono::duration<double>(gap).count() > kLate * options_.period_s;
    if (is_late) ++counters_.overruns;
    overruns_in_a_row_ = is_late ? overruns_in_a_row_ + 1 : 0;
    // Only under power: a device may take its time to switch on.
    if (has_power_ && gap > options_.longest_gap) enterFault(FaultCause::kGap);
    if (has_power_ && overruns_in_a_row_ >= options_.overruns_in_a_row)
      enterFault(FaultCause::kOverruns);
  }
  last_tick_ = now;
}

void Governor::noteDevice(const DeviceReport& device, Time now) {
  watchConnection(device, now);
  device_reports_power_ = is_connected_ && device.powered;
  device_reports_fault_ = is_connected_ && device.fault_code != 0;
  if (!is_connected_) return;
  if (!is_measured_) enterFault(FaultCause::kBadMeasurement);
  if (device_reports_fault_ && !is_resetting_) {
    if (fault_ == FaultCause::kNone) fault_code_ = device.fault_code;
    enterFault(FaultCause::kDevice);
  }
  watchPower(device, now);
  watchMotors(device, now);
}

void Governor::watchConnection(const DeviceReport& device, Time now) {
  const bool is_silent = now - device.measured_at > options_.device_silent_after;
  is_connected_ = device.connected && !is_silent;
  is_measured_ = is_connected_ && measuredIsUsable(device);
  if (is_measured_) {
    std::copy(device.position.begin(), device.position.end(), measured_.begin());
    measured_at_ = device.measured_at;
  }
  if (is_connected_) {
    if (state_ == GovernorState::kDisconnected) state_ = GovernorState::kIdle;
    return;
  }
  if (wants_power_) {
    enterFault(device.connected ? FaultCause::kDeviceSilent : FaultCause::kDeviceLost);
  } else if (state_ == GovernorState::kIdle) {
    state_ = GovernorState::kDisconnected;
  }
}

bool Governor::measuredIsUsable(const DeviceReport& device) const {
  return device.position.size() == measured_.size() &&
         std::all_of(device.position.begin(), device.position.end(), [](double q) {
           return std::isfinite(q);
         });
}

// The device's own deadman shows here: its motors go off though nobody said so.
void Governor::watchPower(const DeviceReport& device, Time now) {
  const bool waited_long =
      power_changed_at_ && now - *power_changed_at_ > options_.power_within;
  if (wants_power_) {
    if (device.powered && !has_power_) {
      // It may have sagged or been pushed while it switched on: begin where it is now.
      has_power_ = true;
      limiter_.reset(measured_);
      guard_.reset(measured_);
      aim_anew_ = true;
    } else if (device.powered) {
      return;
    } else if (has_power_) {
      enterFault(FaultCause::kPowerLost);
    } else if (waited_long) {
      enterFault(FaultCause::kNoPower);
    }
  } else if (device.powered && waited_long) {
    enterFault(FaultCause::kStaysOn);
  }
}

void Governor::watchMotors(const DeviceReport& device, Time now) {
  if (wants_power_ && isFarOutside()) enterFault(FaultCause::kOutOfRange);
  motors_outside_ = device.motors_outside;
  if (wants_power_ && motors_outside_) enterFault(FaultCause::kMotorsOutside);
  if (!device.limited) {
    limited_since_.reset();
    return;
  }
  if (!limited_since_) limited_since_ = now;
  if (state_ == GovernorState::kArmed && now - *limited_since_ > options_.limited_for)
    enterHold(HoldCause::kMotorLimited);
}

bool Governor::isFarOutside() const {
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const JointLimits& limits = options_.limits[i];
    const double slack = options_.outside.of(limits);
    if (measured_[i] < limits.lower - slack || measured_[i] > limits.upper + slack) return true;
  }
  return false;
}

void Governor::finishReset(Time now) {
  if (!is_resetting_) return;
  if (!resetting_since_) resetting_since_ = now;
  if (device_reports_fault_) {
    if (now - *resetting_since_ > options_.reset_within) is_resetting_ = false;
    return;
  }
  is_resetting_ = false;
  must_cut_ = false;
  fault_ = FaultCause::kNone;
  fault_code_ = 0;
  state_ = is_connected_ ? GovernorState::kIdle : GovernorState::kDisconnected;
}

Power Governor::powerless() const {
  const bool cuts = state_ == GovernorState::kEStop && options_.stop_mode == StopMode::kCut;
  return cuts || must_cut_ ? Power::kCut : Power::kOff;
}

// === Motion

MotorOrder Governor::orderUnderPower(Time now) {
  if (!has_power_) {
    // The goal lies where the hand is before power goes on.
    limiter_.reset(measured_);
    guard_.reset(measured_);
    return {Power::kOn, false, limiter_.positions()};
  }
  if (state_ != GovernorState::kArmed) {
    if (!stopping_since_) stopping_since_ = now;
    const bool holds = state_ == GovernorState::kHolding && hold_ != HoldCause::kDisarmed;
    const Time::duration stopped = now - *stopping_since_;
    const Time::duration wait = holds ? options_.hold_for : Milliseconds::zero();
    if ((limiter_.atRest() && stopped >= wait) || stopped >= wait + options_.brake_within) {
      switchOff();
      if (state_ == GovernorState::kHolding) state_ = GovernorState::kIdle;
      return {};
    }
  } else {
    follow();
  }
  limiter_.step();
  counters_.at_velocity += limiter_.activity().at_velocity;
  counters_.at_acceleration += limiter_.activity().at_acceleration;
  if (!guard_.permits(limiter_.positions())) {
    enterFault(FaultCause::kOutput);
    return {};
  }
  return {Power::kOn, false, limiter_.positions()};
}

void Governor::follow() {
  if (aim_anew_) {
    ramping_ = ramping_ || isFarStep();
    limiter_.aim(target_);
  }
  aim_anew_ = false;
  if (ramping_ && isNearTarget(limiter_.positions())) ramping_ = false;
  limiter_.setSpeedShare(ramping_ ? options_.ramp_share : 1.0);
}

bool Governor::isFarStep() const {
  const bool rests = limiter_.atRest();
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double step = options_.step.of(options_.limits[i]);
    const bool jumps = std::abs(target_[i] - limiter_.targets()[i]) > step;
    const bool is_far = std::abs(target_[i] - limiter_.positions()[i]) > step;
    if (is_far && (rests || jumps)) return true;
  }
  return false;
}

bool Governor::isNearTarget(std::span<const double> positions) const {
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double near = options_.near.of(options_.limits[i]);
    if (std::abs(positions[i] - target_[i]) > near) return false;
  }
  return true;
}

}  // namespace handgraft::safety
