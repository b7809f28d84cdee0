#include "hardware/safety/joint_limiter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace handgraft::safety {

namespace {

constexpr std::size_t kMostTaps = 65536;  // half a megabyte a joint
constexpr double kLongestPeriod = 1.0;    // s; slower than that nothing is smooth

void requirePositive(std::size_t joint, const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    rejectInput("joint {}: {} limit {} is not positive and finite", joint, what, value);
  }
}

void validate(std::size_t joint, const JointLimits& limits) {
  if (!(limits.lower <= limits.upper) || limits.lower == HUGE_VAL ||
      limits.upper == -HUGE_VAL) {
    rejectInput("joint {}: lower limit {} is not below its upper limit {}", joint, limits.lower,
                limits.upper);
  }
  requirePositive(joint, "velocity", limits.velocity);
  requirePositive(joint, "acceleration", limits.acceleration);
  requirePositive(joint, "jerk", limits.jerk);
  if (!(limits.margin >= 0) || !std::isfinite(limits.margin)) {
    rejectInput("joint {}: margin {} is not in [0, inf)", joint, limits.margin);
  }
}

// The distance, in units of n dt, that a joint needs to move one period at k n and then brake
// by n a period: k n, (k-1) n, ..., down to the fraction f of k = m + f.
double stoppingDistance(double k) {
  const double m = std::floor(k);
  const double f = k - m;
  return (m + 1) * f + m * (m + 1) / 2;
}

}  // namespace

JointLimiter::JointLimiter(std::vector<JointLimits> limits, double period_s)
    : period_(period_s) {
  if (!(period_s > 0) || !(period_s <= kLongestPeriod)) {
    rejectInput("period {} s is not in (0, {}]", period_s, kLongestPeriod);
  }
  joints_.reserve(limits.size());
  for (std::size_t i = 0; i < limits.size(); ++i) {
    validate(i, limits[i]);
    const JointLimits& limit = limits[i];
    const double taps = std::ceil(2 * limit.acceleration / (limit.jerk * period_));
    if (!(taps <= static_cast<double>(kMostTaps))) {
      rejectInput("joint {}: jerk limit {} needs {} taps at a period of {} s, more than {}", i,
                  limit.jerk, taps, period_, kMostTaps);
    }
    Joint joint;
    joint.limits = limit;
    joint.step_velocity = limit.acceleration * period_;
    joint.full_speed_distance = stoppingDistance(limit.velocity / joint.step_velocity);
    // Half the range at most: a joint that hardly moves is aimed at its middle.
    const double margin = std::min(limit.margin, (limit.upper - limit.lower) / 2);
    joint.lowest = limit.lower + margin;
    joint.highest = std::max(joint.lowest, limit.upper - margin);
    joint.taps.resize(std::max<std::size_t>(1, static_cast<std::size_t>(taps)));
    joints_.push_back(std::move(joint));
  }
  targets_.resize(joints_.size());
  positions_.resize(joints_.size());
}

void JointLimiter::reset(std::span<const double> measured) {
  HANDGRAFT_REQUIRE(measured.size() == joints_.size());
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!std::isfinite(measured[i])) {
      rejectInput("joint {}: measured position {} is not finite", i, measured[i]);
    }
  }
  for (std::size_t i = 0; i < measured.size(); ++i) {
    Joint& joint = joints_[i];
    joint.position = measured[i];
    joint.velocity = 0;
    joint.still_steps = joint.taps.size();
    joint.oldest = 0;
    std::fill(joint.taps.begin(), joint.taps.end(), measured[i]);
    joint.tap_sum = measured[i] * static_cast<double>(joint.taps.size());
    targets_[i] = allowed(i, measured[i]);
    positions_[i] = measured[i];
    // Outside its limits it stays where it is until it is aimed somewhere: a reset moves
    // nothing.
    joint.braking = targets_[i] != measured[i];
  }
  ready_ = true;
}

void JointLimiter::aim(std::span<const double> targets) {
  HANDGRAFT_REQUIRE(targets.size() == joints_.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (!std::isfinite(targets[i])) continue;
    targets_[i] = allowed(i, targets[i]);
    joints_[i].braking = false;
  }
}

double JointLimiter::allowed(std::size_t joint, double target) const {
  HANDGRAFT_REQUIRE(joint < joints_.size());
  return std::clamp(target, joints_[joint].lowest, joints_[joint].highest);
}

void JointLimiter::brake() {
  for (Joint& joint : joints_)
    joint.braking = true;
}

void JointLimiter::setSpeedShare(double share) {
  HANDGRAFT_REQUIRE(share > 0 && share <= 1);
  speed_share_ = share;
}

double JointLimiter::brakingTime(std::size_t joint) const {
  HANDGRAFT_REQUIRE(joint < joints_.size());
  const JointLimits& limits = joints_[joint].limits;
  // Stage 1 loses n a period; then the average runs out.
  const double slowing = std::ceil(limits.velocity / joints_[joint].step_velocity);
  return (slowing + static_cast<double>(joints_[joint].taps.size())) * period_;
}

std::span<const double> JointLimiter::step() {
  HANDGRAFT_REQUIRE(ready_);
  activity_ = {};
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    advance(joints_[i], targets_[i]);
    positions_[i] = average(joints_[i]);
  }
  return positions_;
}

bool JointLimiter::atRest() const {
  return std::all_of(joints_.begin(), joints_.end(), [](const Joint& joint) {
    return joint.still_steps >= joint.taps.size();
  });
}

// The highest velocity from which the joint can still stop after `distance`: the inverse of
// stoppingDistance, whose values at whole k are k (k + 1) / 2.
double JointLimiter::brakingVelocity(const Joint& joint, double distance) const {
  const double top = speed_share_ * joint.limits.velocity;
  const double d = distance / (joint.step_velocity * period_);
  if (d >= joint.full_speed_distance) return top;
  const double m = std::floor(std::sqrt(0.25 + 2 * d) - 0.5);
  const double f = (d - m * (m + 1) / 2) / (m + 1);
  return std::min(top, (m + f) * joint.step_velocity);
}

// Stage 1: exact in velocity and acceleration.
void JointLimiter::advance(Joint& joint, double target) {
  const double distance = joint.braking ? 0.0 : target - joint.position;
  const double top = speed_share_ * joint.limits.velocity;
  const double wanted = std::copysign(brakingVelocity(joint, std::abs(distance)), distance);
  const double slowest = joint.velocity - joint.step_velocity;
  const double fastest = joint.velocity + joint.step_velocity;
  const double before = joint.position;
  joint.velocity = std::clamp(wanted, slowest, fastest);
  if (joint.velocity != wanted) ++activity_.at_acceleration;
  if (std::abs(wanted) >= top) ++activity_.at_velocity;
  // The last step lands on the target itself, not a rounding error beside it.
  const bool lands = !joint.braking && joint.velocity == wanted &&
                     std::abs(distance) <= joint.step_velocity * period_ &&
                     std::abs(distance) <= top * period_;
  joint.position = lands ? target : joint.position + joint.velocity * period_;
  if (joint.velocity == 0 && joint.position == before) {
    joint.still_steps = std::min(joint.still_steps + 1, joint.taps.size());
  } else {
    joint.still_steps = 0;
  }
}

// Stage 2: the average of the last N positions, which bounds the jerk.
double JointLimiter::average(Joint& joint) {
  joint.tap_sum += joint.position - joint.taps[joint.oldest];
  joint.taps[joint.oldest] = joint.position;
  if (++joint.oldest == joint.taps.size()) {
    joint.oldest = 0;
    // Summed afresh once a lap, so that rounding does not pile up over days.
    joint.tap_sum = std::accumulate(joint.taps.begin(), joint.taps.end(), 0.0);
  }
  // At rest the mean is the position, exactly.
  if (joint.still_steps >= joint.taps.size()) return joint.position;
  return joint.tap_sum / static_cast<double>(joint.taps.size());
}

}  // namespace handgraft::safety
