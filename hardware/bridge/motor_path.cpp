#include "hardware/bridge/motor_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

using safety::JointLimits;

constexpr double kMoment = 1e-3;        // s; for velocities; small against any bend of a map
constexpr double kNoDifference = 1e-9;  // rad: rounding of a map there and back
constexpr double kFarthest = 1e4;       // rad
// Full speed after 0.1 s, full acceleration after 0.05 s, as when a motor is homed.
constexpr double kAccelerationPerSpeed = 10;  // 1/s
constexpr double kJerkPerSpeed = 200;         // 1/s^2
// What an elastic hand's tendons stretch comes on top of the speeds that configs are held to.
constexpr double kStretchShare = 0.5;

std::vector<JointLimits> guardLimits(const config::HandConfig& config) {
  const config::TransmissionConfig& transmission = config.transmission;
  const bool stretches = transmission.kind == config::TransmissionKind::kTendons &&
                         transmission.tendons.isElastic();
  const double share = 1 + config.governor.ramp_share + (stretches ? kStretchShare : 0);
  std::vector<JointLimits> limits;
  for (const config::MotorConfig& motor : config.motors) {
    // Acceleration and jerk were asserted for the joints; a bent map keeps no such bound.
    limits.push_back({.lower = motor.range_rad.lower - kNoDifference,
                      .upper = motor.range_rad.upper + kNoDifference,
                      .velocity = share * motor.velocity_rad_s,
                      .acceleration = std::numeric_limits<double>::infinity(),
                      .jerk = std::numeric_limits<double>::infinity(),
                      .margin = 0});
  }
  return limits;
}

std::vector<JointLimits> fadeLimits(const config::HandConfig& config) {
  std::vector<JointLimits> limits;
  for (const config::MotorConfig& motor : config.motors) {
    const double speed = config.governor.ramp_share * motor.velocity_rad_s;
    limits.push_back({.lower = -kFarthest,
                      .upper = kFarthest,
                      .velocity = speed,
                      .acceleration = speed * kAccelerationPerSpeed,
                      .jerk = speed * kJerkPerSpeed,
                      .margin = 0});
  }
  return limits;
}

}  // namespace

MotorPath::MotorPath(const config::HandConfig& config)
    : map_(config::makeMotorMap(config)),
      guard_(guardLimits(config), config.governor.period_s),
      fade_(fadeLimits(config), config.governor.period_s),
      start_(config.motors.size()),
      motors_(config.motors.size()),
      residual_(config.jointCount()),
      moved_(config.motors.size()),
      moved_joints_(config.jointCount()) {
  if (map_->motorCount() != motors_.size() || map_->jointCount() != residual_.size()) {
    rejectInput("the transmission joins {} joints to {} motors; there are {} and {}",
                map_->jointCount(), map_->motorCount(), residual_.size(), motors_.size());
  }
  for (const config::MotorConfig& motor : config.motors)
    ranges_.push_back(motor.range_rad);
}

void MotorPath::measure(std::span<const double> motor_rad,
                        std::span<const double> motor_rad_s,
                        std::span<double> joint_rad,
                        std::span<double> joint_rad_s) {
  map_->measure(motor_rad, joint_rad);
  bool is_told = true;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    moved_[i] = motor_rad[i] + kMoment * motor_rad_s[i];
    is_told = is_told && std::isfinite(moved_[i]);
  }
  if (!is_told) {
    std::fill(joint_rad_s.begin(), joint_rad_s.end(), std::numeric_limits<double>::quiet_NaN());
    return;
  }
  map_->measure(moved_, moved_joints_);
  for (std::size_t i = 0; i < joint_rad.size(); ++i)
    joint_rad_s[i] = (moved_joints_[i] - joint_rad[i]) / kMoment;
}

void MotorPath::reset(std::span<const double> motor_rad) {
  std::copy(motor_rad.begin(), motor_rad.end(), start_.begin());
  guard_.reset(motor_rad);
  is_fresh_ = true;
}

std::span<const double> MotorPath::command(std::span<const double> joint_rad) {
  map_->command(joint_rad, motors_, residual_);
  if (is_fresh_) {
    is_fresh_ = false;
    is_fading_ = false;
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      moved_[i] = start_[i] - motors_[i];
      if (!std::isfinite(moved_[i])) return {};
      is_fading_ = is_fading_ || std::abs(moved_[i]) > kNoDifference;
    }
    if (is_fading_) {
      fade_.reset(moved_);
      std::fill(moved_.begin(), moved_.end(), 0.0);
      fade_.aim(moved_);
    }
  } else if (is_fading_) {
    fade_.step();
    is_fading_ = !fade_.atRest();
  }
  for (std::size_t i = 0; is_fading_ && i < motors_.size(); ++i) {
    motors_[i] =
        std::clamp(motors_[i] + fade_.positions()[i], std::min(ranges_[i].lower, start_[i]),
                   std::max(ranges_[i].upper, start_[i]));
  }
  if (!guard_.permits(motors_)) return {};
  return motors_;
}

}  // namespace handgraft::bridge
