#include "hardware/bridge/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "hardware/bridge/motion_words.h"
#include "hardware/bridge/pose_refusal.h"

namespace handgraft::bridge {

namespace {

using safety::FaultCause;
using safety::GovernorState;
using safety::MotorOrder;
using safety::Power;
using safety::Refusal;
using safety::Time;

constexpr std::chrono::seconds kReopen(1);
// What the governor is told of a fault; the kind itself is kept beside.
constexpr std::uint32_t kGuardCode = 0x100;
constexpr safety::Distance kArrived{2e-3, 1e-4};
constexpr double kFollowable = 0.95;     // of a joint's speed, so that it can catch up
constexpr double kToldBehind = 0.05;     // s
constexpr double kFastestSamples = 2.0;  // times real time: no joint is in the way

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
      samples_(config_.jointCount()),
      stack_(make_device_(config_)),
      zeros_(config_),
      motors_(config_.motors.size(), clock_()),
      measured_(config_.motors.size()),
      state_(config_.jointCount(), config_.motors.size(), stack_.device->touch().size()) {
  state_.is_homed = zeros_.areKnown();
  state_.zeros = zeros_.why();
  state_.needs_homing = !config_.homing.empty();
  for (const std::string& joint : config::motorJoints(config_)) {
    const auto& names = config_.governor.names;
    const auto found = std::find(names.begin(), names.end(), joint);
    joint_of_motor_.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  HANDGRAFT_REQUIRE(stack_.device->motorCount() == config_.motors.size());
  state_.stop_mode = config_.governor.stop_mode;
}

Motion::~Motion() {
  switchOff();
}

// === Between turns

void Motion::offer(const StreamPose& pose) {
  if (pose.stream == state_.stream && samples_.isPlaying(pose.arrived)) return;
  const std::uint64_t clamped = governor_.counters().clamped_samples;
  const safety::SampleVerdict verdict = governor_.offer(
      {pose.stream, pose.sequence, pose.source_ns, pose.names, pose.joint_rad}, pose.arrived);
  if (verdict == safety::SampleVerdict::kAccepted) {
    ++state_.poses_accepted;
    is_clamped_ = governor_.counters().clamped_samples != clamped;
    noteClamping();
    samples_.clear();
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

void Motion::noteClamping() {
  const Clamping clamping = clampingOf(config_.governor, governor_.asked(), governor_.target());
  state_.clamping = clamping.text;
  state_.clamped_rad = clamping.largest_rad;
}

// === Timed samples

void Motion::offer(const TimedPose& sample) {
  if (sample.stream != state_.stream) return;  // its first pose is on its way, or was refused
  const safety::SampleVerdict verdict =
      samples_.add(sample.source_ns, sample.joint_rad, sample.continues, sample.arrived);
  if (verdict == safety::SampleVerdict::kAccepted) {
    ++state_.poses_accepted;
    if (!renewed_at_ || sample.arrived > *renewed_at_) renewed_at_ = sample.arrived;
    pose_refusal_.set("");
    if (is_last_refusal_a_poses_) accept();
    return;
  }
  ++state_.poses_refused;
  // On a network that loses and reorders, late ones are no news, but counted.
  if (verdict == safety::SampleVerdict::kLate || verdict == safety::SampleVerdict::kRepeated)
    return;
  refuse(v1::REFUSAL_POSE, "sample", toString(verdict));
  is_last_refusal_a_poses_ = true;
}

// The pose that the samples ask for now.
void Motion::guide(Time now) {
  const std::span<const double> pose = samples_.advance(now, permittedRate());
  if (pose.empty()) return;
  const std::uint64_t clamped = governor_.counters().clamped_samples;
  if (!governor_.guide(state_.stream, pose, samples_.newestArrival())) return;
  is_clamped_ = governor_.counters().clamped_samples != clamped;
  noteClamping();
}

// Slower than the samples ask for where a joint's speed does not permit it, and where what was
// sent or what is measured has fallen behind by more than following at full speed explains.
double Motion::permittedRate() {
  double rate = std::numeric_limits<double>::infinity();
  slow_joint_ = 0;
  if (governor_.state() != GovernorState::kArmed || governor_.isRamping()) return rate;
  const std::span<const double> sent = governor_.commanded();
  for (std::size_t i = 0; i < samples_.velocity().size(); ++i) {
    const safety::JointLimits& limits = config_.governor.limits[i];
    const double asked = std::abs(samples_.velocity()[i]);
    double permitted = asked > 0 ? kFollowable * limits.velocity / asked : rate;
    if (state_.is_powered && samples_.isPlaying(clock_())) {
      const double at_full_speed =
          limits.velocity * limits.velocity / (2 * limits.acceleration) +
          limits.velocity * limits.acceleration / limits.jerk;
      const double lag =
          std::max(std::abs(governor_.target()[i] - sent[i]),
                   std::abs(state_.command[i] - state_.residual[i] - state_.position[i]));
      const double budget = config_.governor.near.of(limits) + at_full_speed;
      permitted = std::min(permitted, std::clamp(2 * (1 - lag / budget), 0.0, kFastestSamples));
    }
    if (permitted >= rate) continue;
    rate = permitted;
    slow_joint_ = i;
  }
  return rate;
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
      } else if (!zeros_.areKnown()) {
        refuse(
            v1::REFUSAL_NOT_HOMED, "ARM",
            config_.homing.empty() ? "zeros are not known" : "HOME first: zeros are not known",
            zeros_.why().view());
      } else if (const Refusal refusal = governor_.arm(clock_()); refusal != Refusal::kNone) {
        const bool is_pose_wanted = refusal == Refusal::kNoFreshStream;
        const FixedText outside = refusal == Refusal::kMotorsOutside ? motors_.outside()
                                  : refusal == Refusal::kOutOfRange
                                      ? outsideText(config_.governor, state_.position)
                                      : FixedText();
        refuse(codeOf(refusal), "ARM", toString(refusal),
               is_pose_wanted ? pose_refusal_.view() : outside.view());
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
  if (is_open_ || governor_.state() != GovernorState::kDisconnected) return;
  if (!next_open_ || now >= *next_open_) open();
}

void Motion::open() {
  was_slow_ = true;
  is_open_ = has_measured_ = was_armed_ = false;
  zeros_.noteAway();
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
  static_cast<void>(stack_.device->read(measured_));
  if (stack_.device->fault().kind == devices::Fault::Kind::kWire) is_open_ = false;
  has_measured_ = has_measured_ || allFinite(measured_.position);
  if (has_measured_) {
    path_.measure(measured_.position, measured_.velocity, state_.position, state_.velocity);
    zeros_.see(config_, measured_, clock_());
  }
  return is_open_ && has_measured_;
}

void Motion::govern(Time now) {
  safety::DeviceReport report;
  report.connected = measure();
  const devices::Device& device = *stack_.device;
  report.powered = device.isArmed();
  report.fault_code =
      guard_failed_ ? kGuardCode : static_cast<std::uint32_t>(device.fault().kind);
  report.limited =
      report.connected && motors_.isAnyHeldBack(config_, measured_, report.powered, now);
  report.motors_outside = report.connected && motors_.isAnyOutside(config_, measured_);
  report.measured_at = measured_.time;
  report.position = state_.position;
  const FaultCause before = governor_.fault();
  now = std::max(now, clock_());  // reading took its time
  guide(now);
  const MotorOrder order = governor_.tick(report, now);
  if (before == FaultCause::kNone && governor_.fault() != FaultCause::kNone) noteFault();
  obey(order);
}

// The motors go off in this turn: texts may take their time.
void Motion::noteFault() {
  state_.device_fault = stack_.device->fault();
  state_.guard_failed = guard_failed_;
  state_.fault_text.set("");
  if (guard_failed_) return;
  if (governor_.fault() == FaultCause::kMotorsOutside) {
    state_.fault_text.set(
        fmt::format("{}: {}", toString(FaultCause::kMotorsOutside), motors_.outside().view()));
  } else if (governor_.fault() == FaultCause::kOutOfRange) {
    state_.fault_text.set(fmt::format("{}: {}", toString(FaultCause::kOutOfRange),
                                      outsideText(config_.governor, state_.position).view()));
  } else if (governor_.fault() == FaultCause::kDeviceLost ||
             governor_.fault() == FaultCause::kDeviceSilent) {
    state_.fault_text.set(lostText(governor_.fault(), config_.device));
  } else if (governor_.fault() == FaultCause::kDevice) {
    state_.fault_text.set(faultText(*stack_.device, config_, joint_of_motor_));
  }
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
  if (stack_.device->fault().kind == devices::Fault::Kind::kWire) zeros_.noteAway();
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
    zeros_.lose("homing did not end");
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
  const config::HandConfig homed = homing_->config();
  std::string trouble_text;
  if (outcome != HandHoming::State::kDone) trouble_text = homing_->reason();
  homing_.reset();  // frees the wire
  if (trouble_text.empty()) {
    try {
      stack_ = make_device_(homed);
    } catch (const InvalidInput& error) {
      trouble_text = fmt::format("its new zeros are refused: {}", error.what());
    }
  }
  FixedText trouble;
  if (trouble_text.empty()) {
    config_ = homed;
    zeros_.find();
    if (on_homed_) on_homed_(&config_);
  } else {
    stack_ = make_device_(config_);
    trouble.set(trouble_text);
    zeros_.lose(trouble_text);
  }
  open();
  zeros_.noteHeard();
  if (is_open_) state_.trouble = trouble;
}

void Motion::switchOff() {
  if (homing_) homing_->abort(false);
  if (stack_.device && stack_.device->isArmed()) static_cast<void>(stack_.device->disarm());
}

// === What may be told

void Motion::tellSamples(Time now) {
  state_.is_guided = samples_.isPlaying(now);
  state_.samples_skipped = samples_.skipped();
  state_.behind_s = state_.is_guided ? samples_.behind() : 0.0;
  const bool is_slower = state_.is_guided && state_.behind_s > kToldBehind;
  state_.slower.set("");
  if (is_slower) state_.slower.set(config_.governor.names[slow_joint_]);
}

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
  state_.is_homed = zeros_.areKnown();
  state_.zeros = zeros_.why();
  state_.held = motors_.held();
  state_.is_homing = homing_ != nullptr;
  state_.is_powered = homing_ ? homing_->measured() != nullptr : stack_.device->isArmed();
  if (stack_.device) state_.counters = stack_.device->counters();
  noteMotors(config_, measured_, joint_of_motor_, state_);
  if (stack_.device) {
    const std::span<const double> touch = stack_.device->touch();
    std::copy_n(touch.begin(), std::min(touch.size(), state_.touch.size()),
                state_.touch.begin());
  }
  state_.measured_at = measured_.time;
  std::copy(governor_.target().begin(), governor_.target().end(), state_.target.begin());
  state_.tracking_rad = state_.residual_rad = 0;
  state_.is_at_target = true;
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    const double travel = config_.governor.limits[i].travel;
    const double missing = std::abs(state_.position[i] - state_.target[i]);
    if (!(missing <= kArrived.of(config_.governor.limits[i]))) state_.is_at_target = false;
    const double off = std::abs(state_.command[i] - state_.position[i]) / travel;
    if (state_.is_powered) state_.tracking_rad = std::max(state_.tracking_rad, off);
    state_.residual_rad = std::max(state_.residual_rad, std::abs(state_.residual[i]) / travel);
  }
  tellSamples(now);
  state_.command_age = governor_.commandAge(now);
  if (renewed_at_) state_.stream_age = now - *renewed_at_;
  const safety::GovernorCounters& counters = governor_.counters();
  const std::uint64_t limited = counters.at_velocity + counters.at_acceleration;
  if (limited != limited_before_) ++state_.limited;
  limited_before_ = limited;
  if (is_clamped_ && state_.state == GovernorState::kArmed) ++state_.clamped;
}

}  // namespace handgraft::bridge
