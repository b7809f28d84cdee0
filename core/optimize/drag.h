#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// Where a point of a link shall go, and how the link shall be turned there.
struct DragTarget {
  int link = 0;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_W = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d> R_WL;  ///< free where it is missing
};

/// The pairs that ask for it, `weight` in all, without normals: one, or with a rotation six
/// about the place, 5 cm off it, so that a turn by 1 rad weighs as a miss by as much.
std::vector<PointPair> pairsOf(const DragTarget& target, double weight);

/// How far a drag of a finger may take the hand's root along; a drag of what carries the
/// fingers may move it anywhere.
struct DragOptions {
  double root_travel_m = 0.05;  ///< along each axis of W
  double root_turn = 0.5;       ///< rad
};

struct DragResult {
  hand::HandPose pose;
  double short_m = 0.0;    ///< from the target, where it was out of reach
  double short_rad = 0.0;  ///< likewise; 0 where the rotation is free
  bool root_moved = false;
  int evaluations = 0;
};

/// Moves a point of a link to a target: inverse kinematics from the problem's start, in its
/// limits and locks.
///
/// A finger moves alone if that brings it there. Else the whole hand does, the root little: the
/// points of the problem's pairs on other fingers are held softly where they are, which the
/// joints pay for first. What carries several fingers (the palm) moves with the root, while the
/// fingers keep their points in place as well as they can. Out of reach, the answer is the
/// closest pose that was found. Only the problem's hand, start, bounds, locks and points count:
/// not its prior, weights or normals.
///
/// Frames: target in W. Errors: InvalidInput for a target that is not finite or farther than
/// 10 m, and if the problem is not valid; BrokenContract for a link that does not exist.
/// Deterministic. Cost: about 0.3 ms for 26 degrees of freedom.
DragResult drag(const PoseProblem& problem,
                const DragTarget& target,
                const DragOptions& options = {},
                const Progress& progress = Progress());

}  // namespace handgraft::optimize
