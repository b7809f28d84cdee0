#include "core/retargeting/live_leave.h"

#include "core/base/error.h"
#include "core/placement/posture_finding.h"

namespace handgraft::retargeting {

namespace {

Eigen::VectorXd jointsLike(const hand::Hand& hand,
                           const std::vector<contact::PartDirection>& posture) {
  contact::ContactSet shown;
  shown.posture = posture;
  return placement::postureFor(hand, shown).q;
}

}  // namespace

hand::HandPose LiveLeave::goal(const hand::Hand& hand,
                               const Pose& X_OD,
                               const std::vector<contact::PartDirection>& posture,
                               const Eigen::VectorXd& lower,
                               const Eigen::VectorXd& upper) {
  HANDGRAFT_REQUIRE(held_.has_value());
  if (held_->posture_q.size() == 0) held_->posture_q = jointsLike(hand, held_->posture);
  hand::HandPose goal;
  goal.X_WH = X_OD * inverse(held_->X_OD) * held_->hand_O.X_WH;
  // By as much as the posture changes: what it looks like on this hand and what holds differ.
  goal.q = (held_->hand_O.q + jointsLike(hand, posture) - held_->posture_q)
               .cwiseMax(lower)
               .cwiseMin(upper);
  return goal;
}

}  // namespace handgraft::retargeting
