#pragma once

#include <Eigen/Core>

#include "core/optimize/moment_tree.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// Root pose that brings the pairs together best with the joints held at q: closed form over
/// points and normals (Kabsch/Umeyama without scale, SVD), no start needed.
///
/// `normal_length_m` turns a normal's mismatch into metres. With fewer than three pairs, or
/// pairs that do not fix the rotation, the answer is still a proper rotation, and
/// deterministic. Locked coordinates and the root's bounds are kept.
/// Cost: O(pairs + links).
Pose alignRoot(const PoseProblem& problem,
               const Eigen::VectorXd& q,
               double normal_length_m = 0.01);

/// The same from moments collected before. Cost: O(bodies), about 2 us.
Pose alignRoot(const PoseProblem& problem,
               const MomentTree& tree,
               const Eigen::VectorXd& q,
               double normal_length_m = 0.01);

/// `X_WH` turned by R about the weighted centroid of the object's points; as it is where part
/// of the root's rotation is locked.
Pose turnRoot(const PoseProblem& problem,
              const MomentTree& tree,
              const Pose& X_WH,
              const Eigen::Matrix3d& R);

}  // namespace handgraft::optimize
