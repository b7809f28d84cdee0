#include "core/hand/posture.h"

#include <algorithm>
#include <cmath>

#include "core/hand/digits.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

// Of the way from straight to closed: about a human hand at rest.
constexpr double kRelaxed = 1.0 / 3.0;

// Cosine; joints whose axes are nearer to the last one's than that close the finger, too.
constexpr double kParallel = 0.7;

}  // namespace

Eigen::VectorXd relaxedPosture(const HandModel& model, const Eigen::VectorXd& q_straight) {
  Eigen::VectorXd q = model.restPose();
  if (q != model.zeroPose()) return q;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double middle = 0.5 * (model.lower()[j] + model.upper()[j]);
    if (std::isfinite(middle)) q[j] = middle;
  }
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), q_straight, X_SL);
  for (const Digit& digit : findDigits(model, X_SL).digits) {
    for (const int index : digit.nodes) {
      const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(index)];
      if (node.type != JointType::kRevolute || node.dof < 0) continue;
      const double along = digit.flexion_axis.dot(
          X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J);
      if (std::abs(along) < kParallel) continue;
      const bool closes_upwards = along * node.multiplier > 0.0;
      const double closed = closes_upwards ? model.upper()[node.dof] : model.lower()[node.dof];
      if (!std::isfinite(closed)) continue;
      const double straight =
          std::clamp(q_straight[node.dof], model.lower()[node.dof], model.upper()[node.dof]);
      q[node.dof] = straight + kRelaxed * (closed - straight);
    }
  }
  return q;
}

}  // namespace handgraft::hand
