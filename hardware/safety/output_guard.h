#pragma once

#include <array>
#include <span>
#include <vector>

#include "hardware/safety/joint_limiter.h"

namespace handgraft::safety {

/// The last assertion on what leaves for the motors: finite, inside its range, and with finite
/// differences inside the limits. It shares nothing with the limiter that it watches, so a
/// mistake there cannot reach a motor.
///
/// Tolerances: 1e-6 of each limit, and what rounding makes of finite differences of positions.
/// A position outside [lower, upper] is permitted only between there and where `reset` started.
///
/// Cost: O(joints); no allocation after construction.
class OutputGuard {
 public:
  OutputGuard(const std::vector<JointLimits>& limits, double period_s);

  /// Whatever is sent next starts at rest at `start` (rad, one per joint, finite).
  void reset(std::span<const double> start);

  /// True if `positions` may be sent after what was permitted before. What is not permitted is
  /// not remembered.
  bool permits(std::span<const double> positions);

 private:
  struct Joint {
    JointLimits limits;
    double lowest = 0, highest = 0;
    std::array<double, 3> sent{};  // newest first
  };

  [[nodiscard]] bool permits(const Joint& joint, double position) const;

  double period_;
  std::vector<Joint> joints_;
};

}  // namespace handgraft::safety
