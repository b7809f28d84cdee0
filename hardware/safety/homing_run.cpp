#include "hardware/safety/homing_run.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::safety {

namespace {

// Full speed after 0.1 s, full acceleration after 0.05 s: gentle, whatever the speed.
constexpr double kAccelerationPerSpeed = 10;  // 1/s
constexpr double kJerkPerSpeed = 200;         // 1/s^2
// A motor that still creeps at a quarter of its speed is slowed, not stopped.
constexpr double kStandingShare = 0.25;
// What a soft position loop may lag behind while it pushes.
constexpr double kLeashTime = 0.5;  // s
constexpr double kLeash = 0.1;      // rad

JointLimits limitsOf(const HomingStep& step, double start_rad) {
  const auto positive = [](double value) {
    return value > 0 && std::isfinite(value);
  };
  if (!positive(step.speed_rad_s) || !positive(step.current_A) || !positive(step.travel_rad) ||
      !(step.back_off_rad >= 0) || !std::isfinite(step.back_off_rad) ||
      !std::isfinite(step.stop_rad) || !std::isfinite(start_rad) ||
      (step.toward != 1 && step.toward != -1) || step.hold <= Milliseconds::zero()) {
    rejectInput(
        "homing at {} rad/s until {} A for {} ms within {} rad, back by {} rad: each must be "
        "positive and finite",
        step.speed_rad_s, step.current_A, step.hold.count(), step.travel_rad,
        step.back_off_rad);
  }
  return {.lower = start_rad - step.travel_rad,
          .upper = start_rad + step.travel_rad,
          .velocity = step.speed_rad_s,
          .acceleration = step.speed_rad_s * kAccelerationPerSpeed,
          .jerk = step.speed_rad_s * kJerkPerSpeed,
          .margin = 0};
}

}  // namespace

HomingRun::HomingRun(const HomingStep& step, double period_s, double start_rad, Time now)
    : step_(step), limiter_({limitsOf(step, start_rad)}, period_s), start_rad_(start_rad) {
  const std::chrono::duration<double> patience(2 * step.travel_rad / step.speed_rad_s + 1);
  deadline_ = now + std::chrono::duration_cast<Time::duration>(patience) + 2 * step.hold;
  limiter_.reset(std::array{start_rad});
  limiter_.aim(std::array{start_rad + step.toward * step.travel_rad});
}

double HomingRun::tick(double position_rad, double current_A, Time now) {
  const bool runs = state_ == State::kSeeking || state_ == State::kPressing;
  if (runs || state_ == State::kBackingOff) {
    if (!std::isfinite(position_rad) || !std::isfinite(current_A) || now > deadline_) {
      state_ = State::kFailed;
      zero_rad_.reset();
      limiter_.brake();
    }
  }
  if (state_ != State::kFailed) {
    farthest_rad_ = std::max(farthest_rad_, std::abs(position_rad - start_rad_));
    largest_A_ = std::max(largest_A_, std::abs(current_A));
  }
  if (runs && state_ != State::kFailed) seek(position_rad, current_A, now);
  const double leash = kLeash + kLeashTime * step_.speed_rad_s;
  const bool is_ahead = runs && std::abs(limiter_.positions()[0] - position_rad) > leash;
  const double sent = is_ahead ? limiter_.positions()[0] : limiter_.step()[0];
  if (state_ == State::kBackingOff && limiter_.atRest()) state_ = State::kDone;
  return sent;
}

void HomingRun::seek(double position_rad, double current_A, Time now) {
  const bool is_held = std::abs(current_A) >= step_.current_A;
  if (state_ == State::kSeeking) {
    if (is_held) {
      // No harder than this: the target stays where the current rose.
      state_ = State::kPressing;
      pressing_since_ = now;
      pressed_at_rad_ = position_rad;
      limiter_.brake();
    } else if (limiter_.atRest() && limiter_.positions()[0] == limiter_.targets()[0]) {
      state_ = State::kFailed;  // all the way, and nothing held it back
    }
    return;
  }
  const Time::duration pressed = now - pressing_since_;
  if (!is_held) {
    state_ = State::kSeeking;  // friction, or the push at the start
    limiter_.aim(std::array{start_rad_ + step_.toward * step_.travel_rad});
    return;
  }
  if (pressed < step_.hold) return;
  const double crept = std::abs(position_rad - pressed_at_rad_);
  const double slow =
      kStandingShare * step_.speed_rad_s * std::chrono::duration<double>(pressed).count();
  if (crept > slow) {  // it moves: begin to count anew
    pressing_since_ = now;
    pressed_at_rad_ = position_rad;
    return;
  }
  zero_rad_ = position_rad - step_.stop_rad;
  state_ = State::kBackingOff;
  limiter_.aim(std::array{position_rad - step_.toward * step_.back_off_rad});
}

const char* toString(HomingRun::State state) {
  switch (state) {
    case HomingRun::State::kSeeking:
      return "seeking";
    case HomingRun::State::kPressing:
      return "pressing";
    case HomingRun::State::kBackingOff:
      return "backing off";
    case HomingRun::State::kDone:
      return "done";
    case HomingRun::State::kFailed:
      return "failed";
  }
  return "?";
}

}  // namespace handgraft::safety
