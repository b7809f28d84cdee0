#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace handgraft::tendon {

/// A closed interval.
struct Range {
  double lower = 0;
  double upper = 0;
};

/// Between the joints of a hand and the motors that drive them. Motor angles are those of the
/// map's own model, 0 where the hand's model says; the device knows direction and zero.
///
/// Units: rad (m for a prismatic joint); rad/s.
/// Cost: no method but `motorRanges` and `motorSpeeds` allocates.
class MotorMap {
 public:
  virtual ~MotorMap() = default;
  MotorMap() = default;
  MotorMap(const MotorMap&) = delete;
  MotorMap& operator=(const MotorMap&) = delete;

  [[nodiscard]] virtual std::size_t jointCount() const = 0;
  [[nodiscard]] virtual std::size_t motorCount() const = 0;

  /// The motor angles that bring the hand as near to `joint_rad` as it can come, and
  /// `residual_rad` = joint_rad minus the pose that it will take: zero where it can follow.
  virtual void command(std::span<const double> joint_rad,
                       std::span<double> motor_rad,
                       std::span<double> residual_rad) = 0;

  /// The pose of the hand as its motors tell it. After `command` and exact motors that is
  /// joint_rad - residual_rad.
  virtual void measure(std::span<const double> motor_rad, std::span<double> joint_rad) = 0;

  /// Bounds of what `command` can ask of each motor while joints stay within `joints`.
  [[nodiscard]] virtual std::vector<Range> motorRanges(std::span<const Range> joints) const = 0;

  /// Bounds of each motor's speed while no joint is faster than `joint_speeds`.
  [[nodiscard]] virtual std::vector<double> motorSpeeds(
      std::span<const Range> joints, std::span<const double> joint_speeds) const = 0;
};

}  // namespace handgraft::tendon
