#include "core/optimize/objective.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

Objective::Objective(const PoseProblem& problem)
    : Objective(problem, std::make_shared<const MomentTree>(makeMomentTree(problem))) {}

Objective::Objective(const PoseProblem& problem, std::shared_ptr<const MomentTree> tree)
    : problem_(problem), tree_(std::move(tree)), form_(problem.normal_form) {
  HANDGRAFT_REQUIRE(problem.model != nullptr && tree_ != nullptr);
  HANDGRAFT_REQUIRE(problem.prior.q.size() == problem.model->dofCount());
  const int dofs = problem.dofCount();
  HANDGRAFT_REQUIRE(problem.prior_weights.size() == 0 || problem.prior_weights.size() == dofs);
  prior_weights_ = Eigen::VectorXd::Ones(dofs);
  if (problem.prior_weights.size() != 0) {
    prior_weights_ = problem.prior_weights;
    // The rotation's angle is one number, so its three weights count by their mean.
    prior_weights_.head<3>().setConstant(problem.prior_weights.head<3>().mean());
  }
  const auto bodies = static_cast<std::size_t>(tree_->bodyCount());
  bodies_.resize(bodies);
  composites_.resize(bodies);
  terms_.resize(tree_->moments.size());
  if (problem.avoidance != nullptr) {
    avoidance_ = std::make_unique<AvoidanceTerm>(*problem.avoidance, *tree_);
    stiffness_.resize(bodies);
  }
}

double Objective::prior() const {
  const Vector3d shift_W = pose_.X_WH.translation() - problem_.prior.X_WH.translation();
  double sum = prior_weights_[0] * turn_W_.squaredNorm();
  for (int i = 0; i < 3; ++i)
    sum += prior_weights_[3 + i] * shift_W[i] * shift_W[i];
  for (Eigen::Index j = 0; j < pose_.q.size(); ++j) {
    const double difference = pose_.q[j] - problem_.prior.q[j];
    sum += prior_weights_[6 + j] * difference * difference;
  }
  return sum;
}

Terms Objective::evaluate(const hand::HandPose& pose) {
  HANDGRAFT_REQUIRE(pose.q.size() == problem_.model->dofCount());
  if (last_ && pose.q == pose_.q && pose.X_WH.matrix() == pose_.X_WH.matrix()) return *last_;
  last_.reset();
  pose_ = pose;
  placeBodies(*tree_, pose.X_WH.linear(), pose.q, bodies_);
  const Vector3d root_W = pose.X_WH.translation();
  Terms terms;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const BodyMoments& moments = tree_->moments[k];
    const BodyPlace& body = bodies_[static_cast<std::size_t>(moments.body)];
    const Vector3d centroid_W = root_W + body.p_HB_W + body.R_WB.lazyProduct(moments.p_B);
    terms_[k] = optimize::evaluate(moments, body.R_WB, centroid_W, form_);
    terms.distance += terms_[k].distance;
    terms.normal += terms_[k].normal;
  }
  // log(R_P^T R) turned into W; the logarithm is its own axis there and here.
  const Matrix3d R_WH = pose.X_WH.linear();
  turn_W_ = vectorFromRotation(R_WH.lazyProduct(problem_.prior.X_WH.linear().transpose()));
  terms.prior = prior();
  terms.objective = problem_.weights.distance * terms.distance +
                    problem_.weights.normal * terms.normal +
                    problem_.weights.prior * terms.prior;
  if (avoidance_ != nullptr) {
    terms.penetration = avoidance_->evaluate(root_W, bodies_);
    terms.objective += avoidance_->weight() * terms.penetration;
  }
  last_ = terms;
  return terms;
}

Terms Objective::evaluate(const hand::HandPose& pose, Eigen::VectorXd& gradient) {
  const Terms terms = evaluate(pose);
  gatherComposites(false);
  gradient.setZero(problem_.dofCount());
  for (std::size_t k = 0; k < tree_->joints.size(); ++k) {
    const TreeJoint& joint = tree_->joints[k];
    gradient[6 + joint.dof] += joint.multiplier * slopeOf(k);
  }
  gradient.head<3>() = torqueOf(composites_[0].virial);
  gradient.segment<3>(3) = composites_[0].force;
  addPriorGradient(gradient);
  return terms;
}

Eigen::MatrixXd Objective::gaussNewton(const hand::HandPose& pose) {
  static_cast<void>(evaluate(pose));
  QuadraticModel model(problem_.dofCount());
  expand(model);
  return model.gauss_newton;
}

void Objective::addPriorGradient(Eigen::VectorXd& gradient) const {
  const double two_p = 2.0 * problem_.weights.prior;
  gradient.head<3>() += two_p * prior_weights_[0] * turn_W_;
  const Vector3d shift_W = pose_.X_WH.translation() - problem_.prior.X_WH.translation();
  gradient.segment<3>(3) += two_p * prior_weights_.segment<3>(3).cwiseProduct(shift_W);
  for (Eigen::Index j = 0; j < pose_.q.size(); ++j) {
    gradient[6 + j] += two_p * prior_weights_[6 + j] * (pose_.q[j] - problem_.prior.q[j]);
  }
}

}  // namespace handgraft::optimize
