#pragma once

#include <Eigen/Core>

#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The unweighted sums of Eq. 3, 4, 5 and the weighted one of Eq. 2.
struct Terms {
  double distance = 0.0;  ///< m^2
  double normal = 0.0;
  double prior = 0.0;
  double objective = 0.0;
};

/// Eq. 2-5 of the paper with their analytic gradient. Keeps scratch memory: one per thread.
///
/// The prior of the root's rotation is the geodesic angle |log(R_P^T R)|^2. Differs from the
/// paper's coordinate difference, which wraps (DESIGN 3.3).
class Objective {
 public:
  /// Keeps a reference: `problem` must outlive this. BrokenContract if it was not validated.
  explicit Objective(const PoseProblem& problem);

  [[nodiscard]] Terms evaluate(const hand::HandPose& pose);

  /// Also the gradient, 6 + dofs entries: by a rotation increment w (R <- exp(w) R, in W, about
  /// the root's origin), by the root's position in W, by the dofs.
  Terms evaluate(const hand::HandPose& pose, Eigen::VectorXd& gradient);

 private:
  const PoseProblem& problem_;
  hand::LinkPoses X_WL_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> link_wrenches_;
};

}  // namespace handgraft::optimize
