#pragma once

#include <string>
#include <vector>

#include "core/hand/kinematics.h"
#include "core/optimize/pose_problem.h"

#include "tests/bench/retargeting/exact_penetration.h"

namespace handgraft::bench {

// What counts as reached: the product's figures as they stood when the first table was made.
inline constexpr double kReachedMm = 6.0;
inline constexpr double kFacingDeg = 60.0;

/// One patch at a pose.
struct PatchMeasure {
  int patch = -1;
  double mean_mm = 0.0;     ///< between the points of both sides
  double facing_deg = 0.0;  ///< between the mean normals of both sides
  /// Mean distance from the object's points to the nearest place of the finger (or the palm)
  /// that the patch belongs to: knows no pairs of points, and is fair to a pose that was not
  /// solved for them.
  double gap_mm = 0.0;
  bool reached = false;  ///< within kReached_mm and kFacing_deg
};

/// A pose judged; in the same way whoever found it.
struct GraspMeasure {
  std::vector<PatchMeasure> patches;
  // Means over the points of all patches.
  double mean_mm = 0.0;
  double facing_deg = 0.0;
  double gap_mm = 0.0;
  int reached = 0;
  ExactPenetration penetration;
};

/// `problem` tells which points belong together; `parts` names the finger of each link.
/// Frames: object, problem and pose in one.
GraspMeasure measureGrasp(const optimize::PoseProblem& problem,
                          const ExactHand& hand,
                          const std::vector<std::string>& parts,
                          const ExactSolid& object_W,
                          const hand::HandPose& pose);

}  // namespace handgraft::bench
