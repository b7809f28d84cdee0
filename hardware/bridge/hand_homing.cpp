#include "hardware/bridge/hand_homing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

using safety::HomingRun;
using safety::HomingStep;

constexpr double kSlack = 1e-3;  // rad: of a range, so that a unit's rounding fits in
// Of the current that holds a motor back: it has to get there, and no farther.
constexpr double kCurrentShare = 1.25;
constexpr double kTurn = 2 * std::numbers::pi;

// Turns that an encoder is told to count from: another number each time, so that an old
// calibration does not pass for the new one.
double markTurnsOf(devices::TimePoint now, std::size_t motor) {
  const auto seed = static_cast<std::uint64_t>(now.time_since_epoch().count()) + 7919 * motor;
  const std::uint64_t mixed = (seed * 0x9E3779B97F4A7C15U) >> 40;
  return kLeastMarkTurns + static_cast<double>(mixed % 4096) / 64;
}

}  // namespace

HandHoming::HandHoming(config::HandConfig config, MakeDevice make_device, devices::Clock clock)
    : config_(std::move(config)),
      make_device_(std::move(make_device)),
      clock_(std::move(clock)) {
  HANDGRAFT_REQUIRE(!config_.homing.empty());
}

HandHoming::~HandHoming() {
  if (state_ == State::kRunning) abort(false);
}

HandHoming::State HandHoming::turn() {
  if (state_ != State::kRunning) return state_;
  try {
    if (run_) {
      advance();
    } else {
      beginStep();
    }
  } catch (const DeviceError& error) {
    fail(error.what());
  } catch (const TransportError& error) {
    fail(error.what());
  } catch (const InvalidInput& error) {
    fail(error.what());
  }
  return state_;
}

const devices::DeviceState* HandHoming::measured() const {
  return measured_ ? &*measured_ : nullptr;
}

config::HandConfig HandHoming::widened(double start_rad) const {
  config::HandConfig wide = config_;
  const HomingStep& step = config_.homing[step_];
  wide.motors[step.motor].range_rad = {start_rad - step.travel_rad - kSlack,
                                       start_rad + step.travel_rad + kSlack};
  config::MotorConfig& motor = wide.motors[step.motor];
  motor.current_A = std::min(motor.current_A, kCurrentShare * step.current_A);
  motor.velocity_rad_s = step.speed_rad_s;
  return wide;
}

void HandHoming::beginStep() {
  const HomingStep& step = config_.homing[step_];
  // Where the motor stands decides the range, and the range is fixed when a device is made.
  const auto look = [&](const config::HandConfig& config) {
    stack_ = {};
    stack_ = make_device_(config);
    stack_.device->open();
    measured_.emplace(stack_.device->motorCount());
    stack_.device->read(*measured_);
    if (stack_.device->fault()) throw DeviceError(describe(stack_.device->fault()));
    return measured_->position[step.motor];
  };
  const double first = look(config_);
  if (!std::isfinite(first)) throw DeviceError("a motor does not tell where it is");
  start_rad_ = look(widened(first));
  if (!(std::abs(start_rad_ - first) < kSlack))
    throw DeviceError("the motor moves before it is homed");
  run_.emplace(step, config_.governor.period_s, start_rad_, clock_());
  targets_ = measured_->position;
  stack_.device->attend(step.motor);
  stack_.device->arm();
}

void HandHoming::advance() {
  const HomingStep& step = config_.homing[step_];
  devices::Device& device = *stack_.device;
  if (!device.read(*measured_)) {
    fail(describe(device.fault()));
    return;
  }
  const double current = measured_->current[step.motor];
  if (!std::isfinite(current)) return fail("the motor does not tell its current");
  const devices::Duration three_periods(std::chrono::duration_cast<devices::Duration>(
      std::chrono::duration<double>(3 * config_.governor.period_s)));
  // As old as a loop may be late, which its config bounds; HomingRun keeps its target near.
  if (clock_() - measured_->time >
      std::max<devices::Duration>(three_periods, config_.governor.longest_gap))
    return fail("the motors do not tell where they are any more");
  const double sent = run_->tick(measured_->position[step.motor], current, clock_());
  const bool is_sound =
      std::isfinite(sent) && std::abs(sent - start_rad_) <= step.travel_rad + kSlack;
  HANDGRAFT_REQUIRE(is_sound);  // what leaves is asserted here, too
  targets_[step.motor] = sent;
  if (run_->state() == HomingRun::State::kFailed) {
    fail(fmt::format(
        "found no stop: it turned by {:.2f} of {:.4g} rad, its current was {:.3g} A at most, "
        "where {:.3g} A tell a stop",
        run_->farthest(), step.travel_rad, run_->largestCurrent(), step.current_A));
  } else if (run_->state() == HomingRun::State::kDone) {
    finishStep(*run_->zero());
  } else if (!device.write(targets_)) {
    fail(describe(device.fault()));
  }
}

// The device's angle is zero + direction gear angle, of the zero that it was made with.
void HandHoming::finishStep(double zero_rad) {
  const bool is_off = stack_.device->disarm();
  const std::size_t index = config_.homing[step_].motor;
  config::MotorConfig& motor = config_.motors[index];
  const double old_zero_rad = motor.zero_rad;
  motor.zero_rad += motor.direction * motor.gear * zero_rad;
  motor.is_marked = false;
  if (is_off && motor.encoder == config::Encoder::kIncremental) {
    stack_.device->read(*measured_);
    const double stands_rad =
        old_zero_rad + motor.direction * motor.gear * measured_->position[index];
    const double counted_rad = kTurn * markTurnsOf(clock_(), index);
    if (std::isfinite(stands_rad) && stack_.device->recount(index, counted_rad)) {
      motor.zero_rad += counted_rad - stands_rad;
      motor.is_marked = true;
    }
  }
  run_.reset();
  measured_.reset();
  stack_ = {};
  if (!is_off) {
    fail("the motors did not go off");
  } else if (++step_ == config_.homing.size()) {
    state_ = State::kDone;
  }
}

void HandHoming::abort(bool cuts) {
  if (stack_.device && cuts) stack_.device->stop();
  if (stack_.device && !cuts && stack_.device->isArmed()) stack_.device->disarm();
  run_.reset();
  measured_.reset();
  stack_ = {};
  if (state_ == State::kRunning) {
    state_ = State::kFailed;
    reason_ = "homing was given up";
  }
}

void HandHoming::fail(std::string why) {
  const std::string motor =
      step_ < config_.homing.size() ? config_.motors[config_.homing[step_].motor].name : "";
  abort(false);
  state_ = State::kFailed;
  reason_ = fmt::format("homing of {}: {}", quoted(motor), why);
}

}  // namespace handgraft::bridge
