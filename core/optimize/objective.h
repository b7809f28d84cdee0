#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/optimize/link_moments.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The sums of Eq. 3, 4, 5 without their lambdas, and the weighted one of Eq. 2:
/// objective = lambda_d distance + lambda_n normal + lambda_p prior. The weights of single
/// pairs and of single degrees of freedom are part of the sums.
struct Terms {
  double distance = 0.0;  ///< m^2
  double normal = 0.0;
  double prior = 0.0;  ///< rad^2 and m^2
  double objective = 0.0;
};

/// Eq. 2-5 of the paper with their analytic gradient. Keeps scratch memory: one per thread.
///
/// The prior of the root's rotation is the geodesic angle |log(R_P^T R)|^2. Differs from the
/// paper's coordinate difference, which wraps (DESIGN 3.3).
/// Cost: O(links) an evaluation, whatever the number of pairs; allocates in the constructor
/// alone.
class Objective {
 public:
  /// Keeps a reference: `problem` must outlive this. BrokenContract if its sizes disagree or a
  /// pair lies on no link; `validate` says more, and to the user.
  explicit Objective(const PoseProblem& problem);

  [[nodiscard]] Terms evaluate(const hand::HandPose& pose);

  /// Also the gradient, 6 + dofs entries: by a rotation increment w (R <- exp(w) R, in W, about
  /// the root's origin), by the root's position in W, by the dofs.
  Terms evaluate(const hand::HandPose& pose, Eigen::VectorXd& gradient);

  /// Gauss-Newton matrix of Eq. 2 at `pose`, ordered like the gradient: symmetric, positive
  /// semidefinite, and the Hessian where every residual is zero. Allocates.
  /// Cost: O(links with pairs x dofs^2).
  [[nodiscard]] Eigen::MatrixXd gaussNewton(const hand::HandPose& pose);

 private:
  Terms gatherLinks(const hand::HandPose& pose);
  double priorAndGradient(const hand::HandPose& pose, Eigen::VectorXd* gradient) const;
  [[nodiscard]] double priorWeight(int dof) const;

  const PoseProblem& problem_;
  std::vector<LinkMoments> moments_;
  hand::LinkPoses X_WL_;
  /// Column per link: force, then moment about the root's origin, both in W.
  Eigen::Matrix<double, 6, Eigen::Dynamic> link_wrenches_;
};

}  // namespace handgraft::optimize
