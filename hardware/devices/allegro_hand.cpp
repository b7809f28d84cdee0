#include "hardware/devices/allegro_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"

namespace handgraft::devices {

namespace allegro = protocols::allegro;
using allegro::Command;

namespace {

constexpr int kAttempts = 3;
constexpr int kLongestBacklog = 1024;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

AllegroHand::AllegroHand(const AllegroConfig& config, CanChannel& can, Clock clock)
    : config_(config), can_(can), clock_(std::move(clock)) {
  for (std::size_t i = 0; i < config_.scales.size(); ++i)
    validate(config_.scales[i], std::to_string(i), -32768, 32767);
  auto sorted = config_.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (sorted[i] != i) rejectInput("Allegro order: motor {} is not there once", i);
  }
  if (!(config_.stiffness > 0) || !(config_.stiffness <= 10) || !(config_.damping >= 0) ||
      !(config_.damping <= 1)) {
    rejectInput("Allegro stiffness {} Nm/rad or damping {} Nm s/rad is outside (0, 10], [0, 1]",
                config_.stiffness, config_.damping);
  }
  if (!(config_.torque > 0) || !(config_.torque <= 1))
    rejectInput("Allegro torque {} Nm is outside (0, 1]", config_.torque);
  if (config_.reply_timeout <= Duration::zero() || config_.tolerated_misses < 0)
    rejectInput("Allegro timings have to be positive");
}

DeviceCounters AllegroHand::counters() const {
  DeviceCounters counters = counters_;
  counters.damaged = can_.damaged();
  return counters;
}

void AllegroHand::doOpen() {
  can_.open();
  expects_power_ = false;
  misses_.fill(0);
  velocities_.fill(0.0);
  temperatures_.fill(kNaN);
  times_.fill({});
  can_.send(allegro::systemOff());
  askSurely();
  velocities_.fill(0.0);
}

void AllegroHand::doArm() {
  askSurely();
  yieldToStop();
  // No torque before the power comes, and none until it is told where to go.
  pwm_.fill(0);
  sendTorques();
  yieldToStop();
  can_.send(allegro::systemOn());
  askSurely();
  expects_power_ = true;
}

void AllegroHand::doRead(DeviceState& state) {
  can_.send(allegro::askFor(Command::kTemperature, turn_));
  turn_ = (turn_ + 1) % allegro::kFingerCount;
  ask();
  state.time = *std::min_element(times_.begin(), times_.end());
  for (std::size_t finger = 0; finger < misses_.size(); ++finger) {
    const bool is_silent = expects_power_ || clock_() - times_[finger] > kIdlePatience;
    if (misses_[finger] > config_.tolerated_misses && is_silent)
      latch({Fault::Kind::kSilent, static_cast<int>(finger * allegro::kJointsOfFinger), 0});
  }
  for (std::size_t ours = 0; ours < angles_.size(); ++ours) {
    const std::size_t i = config_.order[ours];
    state.position[ours] = angles_[i];
    state.velocity[ours] = velocities_[i];
    state.temperature[ours] = temperatures_[i];
  }
}

void AllegroHand::doWrite(std::span<const double> targets) {
  for (std::size_t ours = 0; ours < targets.size(); ++ours) {
    const std::size_t i = config_.order[ours];
    const MotorScale& scale = config_.scales[i];
    const double target = std::clamp(targets[ours], scale.lower, scale.upper);
    const double wanted =
        config_.stiffness * (target - angles_[i]) - config_.damping * velocities_[i];
    const double torque = std::clamp(wanted, -config_.torque, config_.torque);
    pwm_[i] = static_cast<std::int16_t>(
        std::clamp(std::round(scale.direction * torque * allegro::kPwmPerNm),
                   -double{allegro::kHighestPwm}, double{allegro::kHighestPwm}));
  }
  sendTorques();
}

// It has no word for being off: that it still listens is all that can be known.
bool AllegroHand::doDisarm() {
  doStop();
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    can_.send(allegro::systemOff());
  askSurely();
  return true;
}

void AllegroHand::doStop() {
  expects_power_ = false;
  pwm_.fill(0);
  can_.send(allegro::systemOff());
}

void AllegroHand::doHeal() {
  doStop();
}

// === The bus

void AllegroHand::sendTorques() {
  for (std::size_t finger = 0; finger < allegro::kFingerCount; ++finger) {
    allegro::Numbers numbers{};
    for (std::size_t k = 0; k < numbers.size(); ++k)
      numbers[k] = pwm_[finger * allegro::kJointsOfFinger + k];
    can_.send(allegro::setTorque(finger, numbers));
  }
}

void AllegroHand::take(const protocols::CanFrame& frame) {
  ++counters_.frames;
  if (const auto pose = allegro::poseOf(frame)) {
    const TimePoint now = clock_();
    const bool is_first = times_[pose->finger] == TimePoint{};
    const double seconds = std::chrono::duration<double>(now - times_[pose->finger]).count();
    for (std::size_t k = 0; k < pose->numbers.size(); ++k) {
      const std::size_t i = pose->finger * allegro::kJointsOfFinger + k;
      const double angle = config_.scales[i].angle(pose->numbers[k]);
      if (!is_first && seconds > 0) velocities_[i] = (angle - angles_[i]) / seconds;
      angles_[i] = angle;
    }
    times_[pose->finger] = now;
    misses_[pose->finger] = 0;
    is_answered_[pose->finger] = true;
  } else if (const auto heat = allegro::temperatureOf(frame)) {
    for (std::size_t k = 0; k < heat->numbers.size(); ++k)
      temperatures_[heat->finger * allegro::kJointsOfFinger + k] = heat->numbers[k];
  } else {
    ++counters_.stray;
  }
}

bool AllegroHand::ask() {
  protocols::CanFrame frame;
  const TimePoint start = clock_();
  for (int i = 0; i < kLongestBacklog && can_.receive(frame, start); ++i)
    take(frame);
  is_answered_.fill(false);
  for (std::size_t finger = 0; finger < misses_.size(); ++finger) {
    ++misses_[finger];
    can_.send(allegro::askFor(Command::kFingerPose, finger));
  }
  const auto is_done = [this] {
    return std::all_of(is_answered_.begin(), is_answered_.end(), [](bool told) {
      return told;
    });
  };
  const TimePoint deadline = clock_() + config_.reply_timeout;
  while (!is_done() && can_.receive(frame, deadline)) {
    take(frame);
    if (clock_() > deadline) break;
  }
  counters_.missed +=
      static_cast<std::uint64_t>(std::count(is_answered_.begin(), is_answered_.end(), false));
  return is_done();
}

void AllegroHand::askSurely() {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (ask()) return;
  }
  throw DeviceError("a finger of the Allegro Hand does not answer");
}

}  // namespace handgraft::devices
