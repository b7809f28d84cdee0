#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/optimize/avoidance_term.h"
#include "core/optimize/moment_tree.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The sums of Eq. 3, 4, 5 without their lambdas, and the weighted one of Eq. 2:
/// objective = lambda_d distance + lambda_n normal + lambda_p prior, and what Avoidance
/// charges. The weights of single pairs and of single degrees of freedom are part of the sums.
struct Terms {
  double distance = 0.0;  ///< m^2
  double normal = 0.0;
  double prior = 0.0;  ///< rad^2 and m^2
  double objective = 0.0;
  double penetration = 0.0;  ///< m^2, the sum that Avoidance charges for; 0 without it
};

/// Eq. 2 to second order about a pose, by a rotation increment w (R <- exp(w) R, in W, about
/// the root's origin), by the root's position in W, by the dofs: 6 + dofs entries.
struct QuadraticModel {
  Eigen::VectorXd gradient;
  /// Gauss-Newton matrix: symmetric, positive semidefinite, and the Hessian where every
  /// residual is zero.
  Eigen::MatrixXd gauss_newton;
  /// The Hessian less the Gauss-Newton matrix: residuals times their curvature.
  Eigen::MatrixXd residual_curvature;

  /// Of a problem with `dofs` degrees of freedom, the root's included.
  explicit QuadraticModel(int dofs = 0)
      : gradient(Eigen::VectorXd::Zero(dofs)),
        gauss_newton(Eigen::MatrixXd::Zero(dofs, dofs)),
        residual_curvature(Eigen::MatrixXd::Zero(dofs, dofs)) {}
};

/// Eq. 2-5 of the paper with their exact derivatives. Keeps scratch memory: one per thread.
///
/// The prior of the root's rotation is the geodesic angle |log(R_P^T R)|^2. Differs from the
/// paper's coordinate difference, which wraps.
/// Cost: O(links) an evaluation, whatever the number of pairs; allocates in the constructor
/// alone.
class Objective {
 public:
  /// Keeps a reference: `problem` must outlive this. BrokenContract if its sizes disagree or a
  /// pair lies on no link; `validate` says more, and to the user.
  explicit Objective(const PoseProblem& problem);

  /// The same with moments collected before, to share them among threads.
  Objective(const PoseProblem& problem, std::shared_ptr<const MomentTree> tree);

  /// Asked again for the pose evaluated last, it answers at once: searches begin where others
  /// have just looked.
  [[nodiscard]] Terms evaluate(const hand::HandPose& pose);

  /// Also the gradient, ordered as in QuadraticModel.
  Terms evaluate(const hand::HandPose& pose, Eigen::VectorXd& gradient);

  /// The model about the pose evaluated last. `model` has the problem's size.
  /// Cost: O(joints x depth of the tree).
  void expand(QuadraticModel& model);

  /// Gauss-Newton matrix of Eq. 2 at `pose`. Allocates.
  [[nodiscard]] Eigen::MatrixXd gaussNewton(const hand::HandPose& pose);

  /// Another form of the normal term than the problem's from now on; the next `evaluate`
  /// follows it.
  void setNormalForm(NormalForm form) {
    form_ = form;
    last_.reset();
  }

  /// How penetration is looked for from now on, where the problem charges it; as above.
  void level(const AvoidanceLevel& level) {
    if (avoidance_ != nullptr) avoidance_->level(level);
    last_.reset();
  }

  /// As AvoidanceTerm::swapNear; nothing where penetration is not charged.
  void swapNear(NearLists& near) {
    if (avoidance_ != nullptr) avoidance_->swapNear(near);
  }

  [[nodiscard]] const MomentTree& tree() const { return *tree_; }

 private:
  /// All that lies beyond a joint, about the root's origin, in W.
  struct Composite {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();
    double mass = 0.0;  ///< Gauss-Newton matrix as a rigid body's inertia
    Eigen::Vector3d mass_arm = Eigen::Vector3d::Zero();
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();

    void reset();
    void add(const Composite& other);
  };

  void gatherComposites(bool with_inertia);
  void addJoint(std::size_t joint, QuadraticModel& model) const;
  void addRoot(QuadraticModel& model) const;
  [[nodiscard]] double slopeOf(std::size_t joint) const;
  [[nodiscard]] double prior() const;
  void addPriorGradient(Eigen::VectorXd& gradient) const;
  void addPriorCurvature(QuadraticModel& model) const;
  // === Of Avoidance (objective_avoidance.cpp)
  void pushOut();
  void addAvoidanceCurvature(QuadraticModel& model);
  void addSelfCurvature(const PenetratingSample& touch, QuadraticModel& model);

  const PoseProblem& problem_;
  std::shared_ptr<const MomentTree> tree_;
  NormalForm form_;
  Eigen::VectorXd prior_weights_;  ///< of all dofs; the rotation's are equal

  // === Of the pose evaluated last
  hand::HandPose pose_;
  std::optional<Terms> last_;  ///< nothing before the first, and where what counts has changed
  Eigen::Vector3d turn_W_ = Eigen::Vector3d::Zero();  ///< from the prior's rotation
  std::vector<BodyPlace> bodies_;
  std::vector<BodyTerms> terms_;  ///< per entry of the tree's moments
  std::vector<Composite> composites_;
  std::unique_ptr<AvoidanceTerm> avoidance_;            ///< null unless the problem asks for it
  std::vector<Eigen::Matrix<double, 6, 6>> stiffness_;  ///< of what touches beyond each joint
  std::vector<std::pair<int, double>> chain_;  ///< degrees of freedom, and how a touch follows
};

}  // namespace handgraft::optimize
