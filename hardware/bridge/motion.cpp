#include "hardware/bridge/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "hardware/bridge/pose_refusal.h"

namespace handgraft::bridge {

namespace {

using safety::FaultCause;
using safety::GovernorState;
using safety::MotorOrder;
using safety::Power;
using safety::Refusal;
using safety::SampleVerdict;
using safety::Time;

constexpr std::chrono::seconds kReopen(1);
constexpr double kClamped = 1e-3;   // rad: a margin inside the limits is no news
constexpr double kPushing = 0.95;   // of the current that a motor may use
constexpr double kStanding = 0.05;  // of its speed
// What the governor is told of a fault; the kind itself is kept beside.
constexpr std::uint32_t kGuardCode = 0x100;
// No device of ours restarts in less.
constexpr std::chrono::milliseconds kRestart(300);
// Half the least way that a marked encoder counts from 0: nothing else is so far off.
constexpr double kRestarted_rad = kLeastMark_turns * std::numbers::pi;

v1::BridgeRefusal codeOf(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone:
    case Refusal::kCount:
      return v1::REFUSAL_NONE;
    case Refusal::kNotConnected:
      return v1::REFUSAL_NO_DEVICE;
    case Refusal::kEStop:
      return v1::REFUSAL_ESTOP;
    case Refusal::kFault:
      return v1::REFUSAL_FAULT;
    case Refusal::kNoFreshStream:
      return v1::REFUSAL_NO_FRESH_POSE;
    case Refusal::kNotMeasured:
      return v1::REFUSAL_NOT_MEASURED;
    case Refusal::kOutOfRange:
      return v1::REFUSAL_OUT_OF_RANGE;
    case Refusal::kMotorsOutside:
      return v1::REFUSAL_MOTORS_OUTSIDE;
    case Refusal::kMotorsOn:
      return v1::REFUSAL_MOTORS_ON;
    case Refusal::kNothingToReset:
      return v1::REFUSAL_NOTHING_TO_RESET;
  }
  return v1::REFUSAL_NONE;
}

bool allFinite(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) {
    return std::isfinite(x);
  });
}

}  // namespace

Motion::Motion(config::HandConfig config,
               MakeDevice make_device,
               devices::Clock clock,
               OnHomed on_homed)
    : config_(std::move(config)),
      make_device_(std::move(make_device)),
      clock_(std::move(clock)),
      on_homed_(std::move(on_homed)),
      governor_(config_.governor),
      path_(config_),
      stack_(make_device_(config_)),
      measured_(config_.motors.size()),
      state_(config_.jointCount(), config_.motors.size(), stack_.device->touch().size()),
      free_since_(config_.motors.size(), clock_()) {
  for (const std::string& joint : config::motorJoints(config_)) {
    const auto& names = config_.governor.names;
    const auto found = std::find(names.begin(), names.end(), joint);
    joint_of_motor_.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  HANDGRAFT_REQUIRE(stack_.device->motorCount() == config_.motors.size());
  state_.stop_mode = config_.governor.stop_mode;
  const bool needs_none = config_.homing.empty() && config_.calibration.empty();
  state_.is_homed = needs_none || config_.is_calibrated;
  if (!state_.is_homed && config_.homing.empty())
    state_.zeros.set("there is no calibration yet: `handgraft bridge check` makes one");
  // Whether the device restarted since it was homed, only a mark tells.
  was_away_ = true;
}

Motion::~Motion() {
  switchOff();
}

// === Between turns

void Motion::offer(const StreamPose& pose) {
  const std::uint64_t clamped = governor_.counters().clamped_samples;
  const SampleVerdict verdict = governor_.offer(
      {pose.stream, pose.sequence, pose.source_ns, pose.names, pose.joint_rad}, pose.arrived);
  if (verdict == SampleVerdict::kAccepted) {
    ++state_.poses_accepted;
    is_clamped_ = governor_.counters().clamped_samples != clamped;
    noteClamping();
    state_.stream = pose.stream;
    state_.sequence = pose.sequence;
    renewed_at_ = pose.arrived;
    pose_refusal_.set("");
    if (is_last_refusal_a_poses_) accept();
  } else {
    ++state_.poses_refused;
    pose_refusal_ =
        describeRefusal(verdict, config_.governor.names, pose.names, pose.joint_rad.size());
    refuse(v1::REFUSAL_POSE, "pose", pose_refusal_.view());
    is_last_refusal_a_poses_ = true;
  }
}

// What the limits took of the newest pose: the first joint by name, and how many more.
void Motion::noteClamping() {
  std::size_t count = 0;
  std::size_t worst = 0;
  state_.clamped_rad = 0;
  for (std::size_t i = 0; i < governor_.target().size(); ++i) {
    const double off = std::abs(governor_.asked()[i] - governor_.target()[i]);
    if (off <= kClamped) continue;
    ++count;
    if (off <= state_.clamped_rad) continue;
    state_.clamped_rad = off;
    worst = i;
  }
  state_.clamping.set("");
  if (count == 0) return;
  std::array<char, 200> text{};
  auto end =
      fmt::format_to_n(text.data(), text.size(), "'{}' asked for {:.4g} rad, given {:.4g}",
                       std::string_view(config_.governor.names[worst]).substr(0, 60),
                       governor_.asked()[worst], governor_.target()[worst]);
  std::size_t size = std::min(end.size, text.size());
  if (count > 1) {
    end = fmt::format_to_n(text.data() + size, text.size() - size, "; {} more joints less",
                           count - 1);
    size = std::min(size + end.size, text.size());
  }
  state_.clamping.set({text.data(), size});
}

void Motion::renew(std::uint64_t stream, Time time) {
  governor_.renew(stream, time);
  if (stream == state_.stream && renewed_at_ && time > *renewed_at_) renewed_at_ = time;
}

void Motion::request(Request request) {
  switch (request) {
    case Request::kArm:
      if (homing_) {
        refuse(v1::REFUSAL_IS_HOMING, "ARM", "it is being homed");
      } else if (!state_.is_homed) {
        refuse(v1::REFUSAL_NOT_HOMED, "ARM", "HOME first: zeros are not known",
               state_.zeros.view());
      } else if (const Refusal refusal = governor_.arm(clock_()); refusal != Refusal::kNone) {
        const bool is_pose_wanted = refusal == Refusal::kNoFreshStream;
        const bool is_outside = refusal == Refusal::kMotorsOutside;
        refuse(codeOf(refusal), "ARM", toString(refusal),
               is_pose_wanted ? pose_refusal_.view()
               : is_outside   ? outside_.view()
                              : std::string_view());
      } else {
        state_.trouble.set("");
        accept();
      }
      return;
    case Request::kDisarm:
      accept();
      if (homing_) homing_->abort(false);
      governor_.disarm();
      return;
    case Request::kReset:
      if (const Refusal refusal = governor_.reset(); refusal != Refusal::kNone)
        refuse(codeOf(refusal), "RESET", toString(refusal));
      else
        accept();
      return;
    case Request::kHome:
      beginHoming();
      return;
  }
}

void Motion::estop() {
  accept();
  governor_.estop();
  if (homing_) homing_->abort(config_.governor.stop_mode == safety::StopMode::kCut);
}

void Motion::refuse(v1::BridgeRefusal code,
                    std::string_view what,
                    std::string_view why,
                    std::string_view detail) {
  ++state_.refusals;
  state_.refusal = code;
  is_last_refusal_a_poses_ = false;
  std::array<char, 240> text{};
  const auto end = fmt::format_to_n(text.data(), text.size(), "{} refused: {}{}{}", what, why,
                                    detail.empty() ? "" : ": ", detail);
  state_.last_refusal.set({text.data(), std::min(end.size, text.size())});
}

// What was refused before is no news any more.
void Motion::accept() {
  state_.last_refusal.set("");
  state_.refusal = v1::REFUSAL_NONE;
  is_last_refusal_a_poses_ = false;
}

// === One period

void Motion::turn() {
  was_slow_ = false;
  if (homing_) {
    turnHoming(clock_());
  } else {
    openIfDue(clock_());
    govern(clock_());
  }
  tell(clock_());
}

void Motion::openIfDue(Time now) {
  const bool is_wanted = !is_open_ && governor_.state() == GovernorState::kDisconnected;
  if (is_wanted && (!next_open_ || now >= *next_open_)) open();
}

void Motion::open() {
  was_slow_ = true;
  is_open_ = has_measured_ = was_armed_ = false;
  was_away_ = true;
  try {
    stack_.device->open();
    is_open_ = true;
    next_open_.reset();
    state_.trouble.set("");
  } catch (const TransportError& error) {
    state_.trouble.set(error.what());
  } catch (const DeviceError& error) {
    state_.trouble.set(error.what());
  }
  if (!is_open_) next_open_ = clock_() + kReopen;
}

// The pose, if the device is there and ever told one.
bool Motion::measure() {
  if (!is_open_) return false;
  devices::Device& device = *stack_.device;
  static_cast<void>(device.read(measured_));
  if (device.fault().kind == devices::Fault::Kind::kWire) is_open_ = false;
  has_measured_ = has_measured_ || allFinite(measured_.position);
  if (has_measured_) {
    path_.measure(measured_.position, measured_.velocity, state_.position, state_.velocity);
    watchZeros();
  }
  return is_open_ && has_measured_;
}

// Incremental encoders forget their zeros when they restart. A marked one tells that by its
// count; any other may have restarted whenever it was not heard of for long.
void Motion::watchZeros() {
  if (config_.homing.empty()) return;
  if (clock_() - measured_.time > kRestart) {
    was_away_ = true;
    return;
  }
  for (std::size_t i = 0; state_.is_homed && i < config_.motors.size(); ++i) {
    const config::MotorConfig& motor = config_.motors[i];
    if (motor.encoder != config::Encoder::kIncremental) continue;
    const double at = measured_.position[i];
    const double beyond = std::max(motor.range_rad.lower - at, at - motor.range_rad.upper);
    if (motor.is_marked && beyond > kRestarted_rad / motor.gear) {
      voidZeros(motor.name, "restarted since it was homed");
    } else if (!motor.is_marked && was_away_) {
      voidZeros(motor.name, "cannot say whether it restarted since it was homed");
    }
  }
  was_away_ = false;
}

void Motion::voidZeros(std::string_view motor, std::string_view why) {
  std::array<char, 160> text{};
  const auto end =
      fmt::format_to_n(text.data(), text.size(), "motor '{}' {}", motor.substr(0, 60), why);
  state_.zeros.set({text.data(), std::min(end.size, text.size())});
  state_.is_homed = false;
}

bool Motion::areMotorsOutside() {
  for (std::size_t i = 0; i < config_.motors.size(); ++i) {
    const config::MotorConfig& motor = config_.motors[i];
    const double at = measured_.position[i];
    const double slack = config_.motor_outside_rad;
    // NaN is none of our business here: a measured pose of it is no pose.
    if (!(at < motor.range_rad.lower - slack) && !(at > motor.range_rad.upper + slack))
      continue;
    std::array<char, 160> text{};
    const auto end = fmt::format_to_n(text.data(), text.size(),
                                      "'{}' is at {:.2f} rad, its range {:.4g} to {:.4g}",
                                      std::string_view(motor.name).substr(0, 60), at,
                                      motor.range_rad.lower, motor.range_rad.upper);
    outside_.set({text.data(), std::min(end.size, text.size())});
    return true;
  }
  outside_.set("");
  return false;
}

void Motion::govern(Time now) {
  safety::DeviceReport report;
  report.connected = measure();
  const devices::Device& device = *stack_.device;
  report.powered = device.isArmed();
  report.fault_code =
      guard_failed_ ? kGuardCode : static_cast<std::uint32_t>(device.fault().kind);
  report.limited = report.connected && isAnyHeldBack(now);
  report.motors_outside = report.connected && areMotorsOutside();
  report.measured_at = measured_.time;
  report.position = state_.position;
  const FaultCause before = governor_.fault();
  now = std::max(now, clock_());  // reading took its time
  const MotorOrder order = governor_.tick(report, now);
  if (before == FaultCause::kNone && governor_.fault() != FaultCause::kNone) noteFault();
  obey(order);
}

// The motors go off in this turn: texts may take their time.
void Motion::noteFault() {
  state_.device_fault = stack_.device->fault();
  state_.guard_failed = guard_failed_;
  state_.fault_text.set("");
  if (guard_failed_ || governor_.fault() != FaultCause::kDevice) {
    if (governor_.fault() == FaultCause::kMotorsOutside) {
      state_.fault_text.set(
          fmt::format("{}: {}", toString(FaultCause::kMotorsOutside), outside_.view()));
    }
    return;
  }
  const devices::Fault& fault = state_.device_fault;
  std::string text = devices::describe(fault.kind);
  if (fault.code != 0) {
    const std::string meaning = stack_.device->meaningOf(fault.code);
    text += meaning.empty() ? fmt::format(" (code 0x{:X})", fault.code)
                            : fmt::format(": {} (code 0x{:X})", meaning, fault.code);
  }
  if (fault.motor >= 0) {
    const auto index = static_cast<std::size_t>(fault.motor);
    const config::MotorConfig& motor = config_.motors[index];
    const std::string joint = index < joint_of_motor_.size()
                                  ? config_.governor.names[joint_of_motor_[index]]
                                  : std::string();
    text = fmt::format("motor {} (id {}{}): {}", quoted(motor.name), motor.id,
                       joint.empty() || joint == motor.name ? "" : ", joint " + quoted(joint),
                       text);
  }
  state_.fault_text.set(text);
}

// Held back: the device says so, hot, or it pushes as hard as it may for long, and stands.
bool Motion::isAnyHeldBack(Time now) {
  bool is_held = false;
  for (std::size_t i = 0; i < config_.motors.size(); ++i) {
    const config::MotorConfig& motor = config_.motors[i];
    const double speed = std::abs(measured_.velocity[i]);
    const bool pushes = stack_.device->isArmed() && motor.current_A > 0 &&
                        std::abs(measured_.current[i]) >= kPushing * motor.current_A &&
                        !(speed > kStanding * motor.velocity_rad_s);
    if (!pushes) free_since_[i] = now;
    const bool is_hot = measured_.temperature[i] >= config_.hot_c;
    const bool is_stalled = now - free_since_[i] > config_.stalled_for;
    if (measured_.limited[i] == 0 && !is_hot && !is_stalled) continue;
    if (is_held) continue;
    is_held = true;
    std::array<char, 160> text{};
    const std::string_view name = std::string_view(motor.name).substr(0, 60);
    const auto end =
        is_hot
            ? fmt::format_to_n(text.data(), text.size(), "motor '{}' is hot: {:.0f} degrees C",
                               name, measured_.temperature[i])
        : is_stalled
            ? fmt::format_to_n(text.data(), text.size(),
                               "motor '{}' is stalled: it pushed with {:.2f} A for {:.3g} s",
                               name, std::abs(measured_.current[i]),
                               std::chrono::duration<double>(config_.stalled_for).count())
            : fmt::format_to_n(text.data(), text.size(),
                               "motor '{}' is held back by its device, hot or blocked", name);
    state_.held.set({text.data(), std::min(end.size, text.size())});
  }
  return is_held;
}

void Motion::obey(const MotorOrder& order) {
  if (order.clear_faults) heal();
  devices::Device& device = *stack_.device;
  if (order.power == Power::kOn) {
    if (device.isArmed()) {
      drive(order.positions);
      return;
    }
    arm();
  } else if (order.power == Power::kCut) {
    if (is_open_) device.stop();
  } else if (device.isArmed()) {
    was_slow_ = true;
    if (device.disarm()) governor_.noteMotorsOff();
  }
  was_armed_ = false;
  std::copy(state_.position.begin(), state_.position.end(), state_.command.begin());
  std::fill(state_.residual.begin(), state_.residual.end(), 0.0);
}

void Motion::drive(std::span<const double> joint_rad) {
  devices::Device& device = *stack_.device;
  if (!was_armed_) path_.reset(measured_.position);
  was_armed_ = true;
  const std::span<const double> motors = path_.command(joint_rad);
  if (motors.empty()) {
    guard_failed_ = true;
    device.stop();
    return;
  }
  // What is wrong stays with the device, and the governor hears of it in the next turn.
  static_cast<void>(device.write(motors));
  std::copy(joint_rad.begin(), joint_rad.end(), state_.command.begin());
  std::copy(path_.residual().begin(), path_.residual().end(), state_.residual.begin());
}

void Motion::arm() {
  was_slow_ = true;
  try {
    stack_.device->arm();
  } catch (const DeviceError& error) {
    state_.trouble.set(error.what());
  }
}

void Motion::heal() {
  was_slow_ = true;
  guard_failed_ = false;
  is_open_ = has_measured_ = false;
  next_open_ = clock_() + kReopen;
  was_away_ = was_away_ || stack_.device->fault().kind == devices::Fault::Kind::kWire;
  try {
    stack_.device->reset();
    is_open_ = true;
    state_.trouble.set("");
  } catch (const TransportError& error) {
    state_.trouble.set(error.what());
  } catch (const DeviceError& error) {
    // It answers, but its fault is still there: the governor has to see that.
    is_open_ = static_cast<bool>(stack_.device->fault()) &&
               stack_.device->fault().kind != devices::Fault::Kind::kWire;
    state_.trouble.set(error.what());
  }
}

// === Homing

void Motion::beginHoming() {
  if (homing_) return;
  if (config_.homing.empty()) {
    refuse(v1::REFUSAL_NEEDS_NO_HOMING, "HOME", "this hand needs no homing");
  } else if (governor_.state() != GovernorState::kIdle || stack_.device->isArmed()) {
    refuse(v1::REFUSAL_NOT_IDLE, "HOME", "only with the motors off, in state idle");
  } else {
    accept();
    // Whatever comes of it, what was known before is void.
    state_.is_homed = false;
    state_.zeros.set("homing did not end");
    if (on_homed_) on_homed_(nullptr);
    stack_ = {};  // the wire is needed
    is_open_ = false;
    homing_ = std::make_unique<HandHoming>(config_, make_device_, clock_);
  }
}

// The governor stays idle and watches: it does not know of the power, but what it latches ends
// the homing.
void Motion::turnHoming(Time now) {
  was_slow_ = homing_->measured() == nullptr;
  const HandHoming::State outcome = homing_->turn();
  safety::DeviceReport report;
  report.connected = true;
  report.measured_at = now = std::max(now, clock_());
  report.position = state_.position;
  const MotorOrder order = governor_.tick(report, now);
  if (governor_.state() != GovernorState::kIdle) homing_->abort(order.power == Power::kCut);
  if (homing_->state() == HandHoming::State::kRunning) return;
  state_.trouble.set("");
  if (outcome == HandHoming::State::kDone) {
    config_ = homing_->config();
    state_.is_homed = true;
    state_.zeros.set("");
    if (on_homed_) on_homed_(&config_);
  } else {
    state_.trouble.set(homing_->reason());
    state_.zeros.set(homing_->reason());
  }
  const FixedText trouble = state_.trouble;
  homing_.reset();
  stack_ = make_device_(config_);
  open();
  was_away_ = false;  // it was heard of all the time
  if (is_open_) state_.trouble = trouble;
}

void Motion::switchOff() {
  if (homing_) homing_->abort(false);
  if (stack_.device && stack_.device->isArmed()) static_cast<void>(stack_.device->disarm());
}

// === What may be told

void Motion::tell(Time now) {
  state_.state = governor_.state();
  state_.fault = governor_.fault();
  if (state_.fault == FaultCause::kNone) {
    state_.device_fault = {};
    state_.guard_failed = false;
    state_.fault_text.set("");
  }
  state_.hold = governor_.hold();
  state_.is_slow = governor_.isRamping();
  state_.is_connected = is_open_ && has_measured_;
  state_.is_homing = homing_ != nullptr;
  state_.is_powered = homing_ ? homing_->measured() != nullptr : stack_.device->isArmed();
  if (stack_.device) state_.counters = stack_.device->counters();
  noteMotors();
  state_.measured_at = measured_.time;
  std::copy(governor_.target().begin(), governor_.target().end(), state_.target.begin());
  state_.tracking = 0;
  for (std::size_t i = 0; state_.is_powered && i < state_.position.size(); ++i) {
    const double off = std::abs(state_.command[i] - state_.position[i]);
    state_.tracking = std::max(state_.tracking, off);
  }
  state_.command_age = governor_.commandAge(now);
  if (renewed_at_) state_.stream_age = now - *renewed_at_;
  const safety::GovernorCounters& counters = governor_.counters();
  const std::uint64_t limited = counters.at_velocity + counters.at_acceleration;
  if (limited != limited_before_) ++state_.limited;
  limited_before_ = limited;
  if (is_clamped_ && state_.state == GovernorState::kArmed) ++state_.clamped;
}

void Motion::noteMotors() {
  state_.temperature_c = -1;
  for (std::size_t i = 0; i < config_.motors.size(); ++i) {
    const double told = measured_.temperature[i];
    if (std::isfinite(told)) state_.temperature_c = std::max(state_.temperature_c, told);
    state_.motor_current[i] = measured_.current[i];
    state_.motor_temperature[i] = told;
    if (i < joint_of_motor_.size())
      state_.effort[joint_of_motor_[i]] = config_.motors[i].torque_Nm_A * measured_.current[i];
  }
  if (!stack_.device) return;
  const std::span<const double> touch = stack_.device->touch();
  std::copy_n(touch.begin(), std::min(touch.size(), state_.touch.size()), state_.touch.begin());
}

}  // namespace handgraft::bridge
