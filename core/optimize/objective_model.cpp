// Derivatives of Eq. 2 over the kinematic tree, leaves first (Featherstone 2008, "Rigid Body
// Dynamics Algorithms", 6.2: the Gauss-Newton matrix is a joint space inertia).

#include <cmath>

#include "core/base/error.h"
#include "core/optimize/objective.h"

namespace handgraft::optimize {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using hand::JointType;

}  // namespace

void Objective::Composite::reset() {
  force.setZero();
  virial.setZero();
  mass = 0.0;
  mass_arm.setZero();
  inertia.setZero();
}

void Objective::Composite::add(const Composite& other) {
  force += other.force;
  virial += other.virial;
  mass += other.mass;
  mass_arm += other.mass_arm;
  inertia += other.inertia;
}

void Objective::gatherComposites(bool with_inertia) {
  HANDGRAFT_REQUIRE(pose_.q.size() == problem_.model->dofCount());
  for (Composite& composite : composites_)
    composite.reset();
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const BodyMoments& moments = tree_->moments[k];
    const auto index = static_cast<std::size_t>(moments.body);
    const BodyPlace& body = bodies_[index];
    const BodyPull pull =
        pullOf(moments, body.R_WB, terms_[k], problem_.weights, form_, with_inertia);
    const Vector3d arm_W = body.p_HB_W + body.R_WB.lazyProduct(moments.p_B);
    Composite& own = composites_[index];
    own.force = pull.force;
    own.virial = pull.virial + arm_W * pull.force.transpose();
    if (!with_inertia) continue;
    own.mass = 2.0 * problem_.weights.distance * moments.weight;
    own.mass_arm = own.mass * arm_W;
    own.inertia = pull.inertia - own.mass_arm * arm_W.transpose();
    own.inertia.diagonal().array() += own.mass_arm.dot(arm_W);
  }
  if (avoidance_ != nullptr) pushOut();
  // Children stand behind their parents.
  for (std::size_t k = tree_->joints.size(); k-- > 0;) {
    composites_[static_cast<std::size_t>(tree_->joints[k].parent_body)].add(composites_[k + 1]);
  }
}

double Objective::slopeOf(std::size_t joint) const {
  const BodyPlace& body = bodies_[joint + 1];
  const Composite& beyond = composites_[joint + 1];
  if (tree_->joints[joint].type != JointType::kRevolute) return body.axis_W.dot(beyond.force);
  return body.axis_W.dot(torqueOf(beyond.virial) - body.p_HB_W.cross(beyond.force));
}

void Objective::expand(QuadraticModel& model) {
  HANDGRAFT_REQUIRE(model.gradient.size() == problem_.dofCount());
  gatherComposites(true);
  model.gradient.setZero();
  model.gauss_newton.setZero();
  model.residual_curvature.setZero();
  addRoot(model);
  for (std::size_t k = 0; k < tree_->joints.size(); ++k)
    addJoint(k, model);
  addPriorGradient(model.gradient);
  addPriorCurvature(model);
  if (avoidance_ != nullptr) addAvoidanceCurvature(model);
}

void Objective::addRoot(QuadraticModel& model) const {
  const Composite& all = composites_[0];
  model.gradient.head<3>() = torqueOf(all.virial);
  model.gradient.segment<3>(3) = all.force;
  auto& H = model.gauss_newton;
  H.topLeftCorner<3, 3>() = all.inertia;
  H.block<3, 3>(0, 3) = crossMatrix(all.mass_arm);
  H.block<3, 3>(3, 0) = -crossMatrix(all.mass_arm);
  H.block<3, 3>(3, 3).diagonal().setConstant(all.mass);
  // exp(w) a = a + w x a + w x (w x a) / 2.
  auto turn = model.residual_curvature.topLeftCorner<3, 3>();
  turn = 0.5 * (all.virial + all.virial.transpose());
  turn.diagonal().array() -= all.virial.trace();
}

void Objective::addJoint(std::size_t joint, QuadraticModel& model) const {
  const TreeJoint& own = tree_->joints[joint];
  const BodyPlace& body = bodies_[joint + 1];
  const Composite& beyond = composites_[joint + 1];
  const double m = own.multiplier;
  const Eigen::Index dof = 6 + own.dof;
  model.gradient[dof] += m * slopeOf(joint);

  // What moves is the inertia beyond; `momentum` and `shift` are its share per unit of motion.
  // `bend` dotted with an earlier axis is the force times the second derivative of the place.
  const Vector3d& axis = body.axis_W;
  Vector3d momentum;  // about the root's origin
  Vector3d shift;
  Vector3d bend;
  if (own.type == JointType::kRevolute) {
    const Vector3d velocity = body.p_HB_W.cross(axis);  // of what stands at the root's origin
    shift = beyond.mass * velocity + axis.cross(beyond.mass_arm);
    momentum = beyond.inertia.lazyProduct(axis) + beyond.mass_arm.cross(velocity);
    const Matrix3d virial = beyond.virial - body.p_HB_W * beyond.force.transpose();
    bend = virial.lazyProduct(axis) - virial.trace() * axis;
  } else {
    shift = beyond.mass * axis;
    momentum = beyond.mass_arm.cross(axis);
    bend = axis.cross(beyond.force);
  }

  auto& H = model.gauss_newton;
  auto& S = model.residual_curvature;
  H.block<3, 1>(0, dof) += m * momentum;
  H.block<3, 1>(3, dof) += m * shift;
  S.block<3, 1>(0, dof) += m * bend;
  H.block<1, 3>(dof, 0) += m * momentum.transpose();
  H.block<1, 3>(dof, 3) += m * shift.transpose();
  S.block<1, 3>(dof, 0) += m * bend.transpose();
  for (int at = static_cast<int>(joint) + 1; at > 0;) {
    const auto index = static_cast<std::size_t>(at);
    const TreeJoint& before = tree_->joints[index - 1];
    const BodyPlace& state = bodies_[index];
    const Eigen::Index before_dof = 6 + before.dof;
    const double factor = m * before.multiplier;
    double h = 0.0;
    double s = 0.0;
    if (before.type == JointType::kRevolute) {
      h = factor * state.axis_W.dot(momentum - state.p_HB_W.cross(shift));
      s = factor * state.axis_W.dot(bend);
    } else {
      h = factor * state.axis_W.dot(shift);
    }
    // A slider does not bend its own path.
    if (index == joint + 1 && own.type != JointType::kRevolute) s = 0.0;
    H(before_dof, dof) += h;
    S(before_dof, dof) += s;
    if (index != joint + 1) {
      H(dof, before_dof) += h;
      S(dof, before_dof) += s;
    }
    at = before.parent_body;
  }
}

void Objective::addPriorCurvature(QuadraticModel& model) const {
  const double two_p = 2.0 * problem_.weights.prior;
  model.gauss_newton.diagonal() += two_p * prior_weights_;
  // Of |log R|^2: 2 along the axis, less across it, nothing at half a turn.
  const double angle = turn_W_.norm();
  if (angle < 1e-6) return;
  const Vector3d axis = turn_W_ / angle;
  const double across = 0.5 * angle / std::tan(0.5 * angle) - 1.0;
  auto turn = model.residual_curvature.topLeftCorner<3, 3>();
  const double scale = two_p * prior_weights_[0] * across;
  turn -= scale * axis * axis.transpose();
  turn.diagonal().array() += scale;
}

}  // namespace handgraft::optimize
