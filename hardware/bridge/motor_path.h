#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hardware/config/hand_config.h"
#include "hardware/safety/joint_limiter.h"
#include "hardware/safety/output_guard.h"
#include "hardware/tendon/motor_map.h"

namespace handgraft::bridge {

/// From joints to motors and back: the hand's transmission, a start where the motors are, and
/// the last assertion on what leaves.
///
/// What the governor permits starts at the measured pose. The motors that this pose asks for
/// need not be where the motors are: a hand may stand where its transmission cannot put it, a
/// tendon may be slack. The difference is added at first and fades at `ramp_share` of each
/// motor's speed.
///
/// Cost: that of the map twice; nothing allocates after construction.
class MotorPath {
 public:
  /// Errors: InvalidInput as of makeMotorMap.
  explicit MotorPath(const config::HandConfig& config);

  [[nodiscard]] std::size_t jointCount() const { return residual_.size(); }

  [[nodiscard]] std::size_t motorCount() const { return motors_.size(); }

  /// The pose and its velocity (rad, rad/s) that motors tell. Velocities that are not told are
  /// NaN, and so is what follows from them.
  void measure(std::span<const double> motor_rad,
               std::span<const double> motor_rad_s,
               std::span<double> joint_rad,
               std::span<double> joint_rad_s);

  /// Whatever is commanded next starts at rest at `motor_rad`.
  void reset(std::span<const double> motor_rad);

  /// What motors are to be sent for a pose (rad); valid until the next call. Empty when the
  /// last assertion fails: not finite, out of the motor's range, or faster than it may be.
  std::span<const double> command(std::span<const double> joint_rad);

  /// Of the last `command`, rad: what of the pose the hand cannot follow.
  [[nodiscard]] const std::vector<double>& residual() const { return residual_; }

 private:
  std::unique_ptr<tendon::MotorMap> map_;
  std::vector<tendon::Range> ranges_;
  safety::OutputGuard guard_;
  safety::JointLimiter fade_;
  bool is_fading_ = false;
  bool is_fresh_ = false;  // nothing was commanded since the reset
  std::vector<double> start_;
  std::vector<double> motors_;
  std::vector<double> residual_;
  std::vector<double> moved_;  // motors a moment later, and the joints that tells
  std::vector<double> moved_joints_;
};

}  // namespace handgraft::bridge
