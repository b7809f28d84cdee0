#include "core/optimize/objective.h"

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

using hand::HandModel;
using hand::JointType;

}  // namespace

Objective::Objective(const PoseProblem& problem) : problem_(problem) {
  HANDGRAFT_REQUIRE(problem.model != nullptr);
  const int links = problem.model->linkCount();
  for (const PointPair& pair : problem.pairs) {
    HANDGRAFT_REQUIRE(pair.link >= 0 && pair.link < links);
  }
  HANDGRAFT_REQUIRE(problem.prior.q.size() == problem.model->dofCount());
  HANDGRAFT_REQUIRE(problem.prior_weights.size() == 0 ||
                    problem.prior_weights.size() == problem.dofCount());
  moments_ = collectMoments(problem);
  X_WL_.resize(static_cast<std::size_t>(links));
  link_wrenches_.setZero(6, links);
}

double Objective::priorWeight(int dof) const {
  if (problem_.prior_weights.size() == 0) return 1.0;
  // The rotation's angle is one number, so its three weights count by their mean.
  if (dof < 3) return problem_.prior_weights.head<3>().mean();
  return problem_.prior_weights[dof];
}

Terms Objective::gatherLinks(const hand::HandPose& pose) {
  forwardKinematics(*problem_.model, pose.X_WH, pose.q, X_WL_);
  link_wrenches_.setZero();
  const Eigen::Vector3d root_W = pose.X_WH.translation();
  Terms terms;
  for (const LinkMoments& moments : moments_) {
    const LinkTerms link = optimize::evaluate(
        moments, X_WL_[static_cast<std::size_t>(moments.link)], problem_.weights);
    terms.distance += link.distance;
    terms.normal += link.normal;
    auto wrench = link_wrenches_.col(moments.link);
    wrench.head<3>() = link.force;
    wrench.tail<3>() = link.moment + (link.centroid_W - root_W).cross(link.force);
  }
  return terms;
}

double Objective::priorAndGradient(const hand::HandPose& pose,
                                   Eigen::VectorXd* gradient) const {
  const double lambda = problem_.weights.prior;
  const Eigen::Matrix3d R_PH = problem_.prior.X_WH.linear().transpose() * pose.X_WH.linear();
  const Eigen::Vector3d angle_H = vectorFromRotation(R_PH);
  const Eigen::Vector3d shift_W = pose.X_WH.translation() - problem_.prior.X_WH.translation();
  double sum = priorWeight(0) * angle_H.squaredNorm();
  for (int i = 0; i < 3; ++i)
    sum += priorWeight(3 + i) * shift_W[i] * shift_W[i];
  const int joints = problem_.model->dofCount();
  for (int j = 0; j < joints; ++j) {
    const double difference = pose.q[j] - problem_.prior.q[j];
    sum += priorWeight(6 + j) * difference * difference;
    if (gradient != nullptr) {
      (*gradient)[6 + j] += 2.0 * lambda * priorWeight(6 + j) * difference;
    }
  }
  if (gradient != nullptr) {
    // d|log(R_PH)|^2 by a turn of H about itself is 2 log(R_PH): the Jacobian keeps its own
    // axis.
    gradient->head<3>() += 2.0 * lambda * priorWeight(0) * (pose.X_WH.linear() * angle_H);
    for (int i = 0; i < 3; ++i) {
      (*gradient)[3 + i] += 2.0 * lambda * priorWeight(3 + i) * shift_W[i];
    }
  }
  return sum;
}

Terms Objective::evaluate(const hand::HandPose& pose) {
  Terms terms = gatherLinks(pose);
  terms.prior = priorAndGradient(pose, nullptr);
  terms.objective = problem_.weights.distance * terms.distance +
                    problem_.weights.normal * terms.normal +
                    problem_.weights.prior * terms.prior;
  return terms;
}

Terms Objective::evaluate(const hand::HandPose& pose, Eigen::VectorXd& gradient) {
  Terms terms = gatherLinks(pose);
  gradient.setZero(problem_.dofCount());

  // Leaves first: each joint feels the wrench of everything beyond it.
  const Eigen::Vector3d root_W = pose.X_WH.translation();
  const auto& nodes = problem_.model->nodes();
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
    const auto wrench = link_wrenches_.col(node->link);
    if (node->dof >= 0) {
      const Pose& X_WL = X_WL_[static_cast<std::size_t>(node->link)];
      const Eigen::Vector3d axis_W = X_WL.linear() * node->axis_J;
      double slope = 0.0;
      if (node->type == JointType::kRevolute) {
        const Eigen::Vector3d arm_W = X_WL.translation() - root_W;
        slope = axis_W.dot(wrench.tail<3>() - arm_W.cross(wrench.head<3>()));
      } else {
        slope = axis_W.dot(wrench.head<3>());
      }
      gradient[6 + node->dof] += node->multiplier * slope;
    }
    link_wrenches_.col(node->parent_link) += wrench;
  }
  gradient.head<3>() = link_wrenches_.col(0).tail<3>();
  gradient.segment<3>(3) = link_wrenches_.col(0).head<3>();

  terms.prior = priorAndGradient(pose, &gradient);
  terms.objective = problem_.weights.distance * terms.distance +
                    problem_.weights.normal * terms.normal +
                    problem_.weights.prior * terms.prior;
  return terms;
}

Eigen::MatrixXd Objective::gaussNewton(const hand::HandPose& pose) {
  const HandModel& model = *problem_.model;
  forwardKinematics(model, pose.X_WH, pose.q, X_WL_);
  const int dofs = problem_.dofCount();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dofs, dofs);
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, dofs);
  for (const LinkMoments& moments : moments_) {
    const Pose& X_WL = X_WL_[static_cast<std::size_t>(moments.link)];
    const Eigen::Vector3d centroid_W = X_WL * moments.p_L;
    J.leftCols<6>().setIdentity();
    J.block<3, 3>(3, 0) = -crossMatrix(centroid_W - pose.X_WH.translation());
    J.rightCols(model.dofCount()) = pointJacobian(model, X_WL_, moments.link, centroid_W);
    H.noalias() += J.transpose() * (gaussNewtonOf(moments, X_WL, problem_.weights) * J);
  }
  for (int i = 0; i < dofs; ++i)
    H(i, i) += 2.0 * problem_.weights.prior * priorWeight(i);
  return H;
}

}  // namespace handgraft::optimize
