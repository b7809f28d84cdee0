#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/optimize/moment_tree.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The degrees of freedom that a search may move, in an order that suits elimination: fingers
/// one by one, tips first, the root's rotation and translation last.
struct SearchSpace {
  std::vector<int> dofs;  ///< as PoseProblem numbers them
  Eigen::VectorXd lower;  ///< per entry of `dofs`; infinite where there is none
  Eigen::VectorXd upper;
  /// First entry that entry i meets in the Hessian of Eq. 2, or i itself.
  std::vector<int> first;
  /// One or two axes of the root's rotation are locked: coordinates of the rotation vector
  /// stay, which a rotation increment would change.
  bool rotation_partly_locked = false;
};

/// Locked degrees of freedom, and those whose bounds meet, are left out.
SearchSpace makeSearchSpace(const PoseProblem& problem, const MomentTree& tree);

}  // namespace handgraft::optimize
