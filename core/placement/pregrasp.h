#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/base/progress.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::placement {

/// How a hand stands before it closes: its root where it grasps, its joints such that it is
/// clear of the object.
struct Pregrasp {
  Eigen::VectorXd q;
  bool is_clear = false;  ///< nothing of the hand is more than half a millimetre inside
  double depth_m = 0.0;   ///< in the object
};

/// The rest pose where it is clear, and so is the way to it from the grasp. Else the fingers go
/// from the grasp towards the limits that take what touches away from the object, as far as
/// they stay clear. Where neither is clear, the least deep of both, and `is_clear` is false.
///
/// `pairs`: what touches, normals of the object in W; joints that move none of it stay. A rest
/// pose may be a closed one (grippers), and lie in the object. Errors: Cancelled on wish.
/// Cost: some 20 depths, a millisecond each.
Pregrasp pregraspOf(const hand::Hand& hand,
                    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                    const Pose& X_WO,
                    const hand::HandPose& grasp,
                    const std::vector<optimize::PointPair>& pairs,
                    const Progress& progress);

}  // namespace handgraft::placement
