#include "core/retargeting/live_approach.h"

#include "core/placement/posture_finding.h"

namespace handgraft::retargeting {

std::optional<LiveApproach> LiveApproach::from(const hand::Hand& hand,
                                               const manipulation::ShownHand& shown) {
  if (!shown.X_OD || !shown.grip_O) return std::nullopt;
  contact::ContactSet posed;
  posed.posture = shown.posture;
  const placement::Posture posture = placement::postureFor(hand, posed);
  if (!posture.R_OH) return std::nullopt;  // relaxed, since nobody knows more
  return LiveApproach(hand, shown.X_OD->linear().transpose() * *posture.R_OH, posture.q);
}

std::optional<hand::HandPose> LiveApproach::goal(const manipulation::ShownHand& shown,
                                                 const Eigen::VectorXd& lower,
                                                 const Eigen::VectorXd& upper) {
  if (!shown.X_OD || !shown.grip_O) return std::nullopt;
  hand::HandPose goal;
  goal.X_WH.linear() = shown.X_OD->linear() * R_DH_;
  q_ = placement::jointsLike(hand_, shown.posture, goal.X_WH.linear(), q_);
  goal.q = q_.cwiseMax(lower).cwiseMin(upper);
  const auto grip_O = grip_.at(hand::forwardKinematics(*hand_.model, goal));
  if (!grip_O) return std::nullopt;
  goal.X_WH.translation() = *shown.grip_O - *grip_O;
  return goal;
}

}  // namespace handgraft::retargeting
