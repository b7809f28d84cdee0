// What Avoidance adds to the derivatives of the objective. Its forces join those of the pairs,
// so that gradient and the curvature of paths come out of the same pass over the tree; its
// Gauss-Newton matrix is laid beside theirs, since springs at single places are no rigid body.

#include <algorithm>

#include "core/optimize/objective.h"

namespace handgraft::optimize {

namespace {

using Eigen::Vector3d;
using hand::JointType;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// How a place's way along a slope follows a turn about the root's origin, and a shift.
Vector6d wrenchOf(const PenetratingSample& touch) {
  Vector6d wrench;
  wrench << touch.arm_W.cross(touch.slope_W), touch.slope_W;
  return wrench;
}

/// A joint's motion of what lies beyond it: its turn, and what it does at the root's origin.
Vector6d twistOf(const TreeJoint& joint, const BodyPlace& body) {
  Vector6d twist;
  if (joint.type == JointType::kRevolute) {
    twist << body.axis_W, body.p_HB_W.cross(body.axis_W);
  } else {
    twist << Vector3d::Zero(), body.axis_W;
  }
  return joint.multiplier * twist;
}

}  // namespace

void Objective::pushOut() {
  const double two_l = 2.0 * avoidance_->weight();
  for (const PenetratingSample& touch : avoidance_->touches()) {
    const Vector3d force = -two_l * touch.weight * touch.depth * touch.slope_W;
    Composite& own = composites_[static_cast<std::size_t>(touch.body)];
    own.force += force;
    own.virial += touch.arm_W * force.transpose();
    if (touch.other < 0) continue;
    Composite& other = composites_[static_cast<std::size_t>(touch.other)];
    other.force -= force;
    other.virial -= touch.arm_W * force.transpose();
  }
}

void Objective::addAvoidanceCurvature(QuadraticModel& model) {
  if (avoidance_->touches().empty()) return;
  const double two_l = 2.0 * avoidance_->weight();
  for (auto& stiffness : stiffness_)
    stiffness.setZero();
  for (const PenetratingSample& touch : avoidance_->touches()) {
    if (touch.other >= 0) {
      addSelfCurvature(touch, model);
      continue;
    }
    const Vector6d wrench = wrenchOf(touch);
    stiffness_[static_cast<std::size_t>(touch.body)] +=
        (two_l * touch.weight * wrench) * wrench.transpose();
  }
  for (std::size_t k = tree_->joints.size(); k-- > 0;)
    stiffness_[static_cast<std::size_t>(tree_->joints[k].parent_body)] += stiffness_[k + 1];

  auto& H = model.gauss_newton;
  H.topLeftCorner<6, 6>() += stiffness_[0];
  for (std::size_t k = 0; k < tree_->joints.size(); ++k) {
    const Vector6d pull = stiffness_[k + 1] * twistOf(tree_->joints[k], bodies_[k + 1]);
    const Eigen::Index dof = 6 + tree_->joints[k].dof;
    H.block<6, 1>(0, dof) += pull;
    H.block<1, 6>(dof, 0) += pull.transpose();
    for (int at = static_cast<int>(k) + 1; at > 0;) {
      const auto index = static_cast<std::size_t>(at);
      const TreeJoint& before = tree_->joints[index - 1];
      const double h = twistOf(before, bodies_[index]).dot(pull);
      H(6 + before.dof, dof) += h;
      if (index != k + 1) H(dof, 6 + before.dof) += h;
      at = before.parent_body;
    }
  }
}

void Objective::addSelfCurvature(const PenetratingSample& touch, QuadraticModel& model) {
  // (a + b)^2 <= 2 a^2 + 2 b^2: each branch for itself, which keeps fingers apart in the
  // matrix.
  const double scale = 4.0 * avoidance_->weight() * touch.weight;
  const Vector6d wrench = wrenchOf(touch);
  const auto parent_of = [this](int body) {
    return tree_->joints[static_cast<std::size_t>(body - 1)].parent_body;
  };
  // Parents have lower numbers than their children: the higher one is never above the other.
  int meeting = touch.body;
  for (int other = touch.other; meeting != other;)
    (meeting > other ? meeting : other) = parent_of(std::max(meeting, other));

  // Each joint's slope once: there are hundreds of touches where fingers meet.
  for (const int tip : {touch.body, touch.other}) {
    chain_.clear();
    for (int a = tip; a != meeting; a = parent_of(a)) {
      const auto row = static_cast<std::size_t>(a);
      const TreeJoint& joint = tree_->joints[row - 1];
      chain_.emplace_back(6 + joint.dof, twistOf(joint, bodies_[row]).dot(wrench));
    }
    for (const auto& [row, slope] : chain_)
      for (const auto& [column, other] : chain_)
        model.gauss_newton(row, column) += scale * slope * other;
  }
}

}  // namespace handgraft::optimize
