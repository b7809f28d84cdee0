#include "core/retargeting/going_along.h"

#include "core/placement/posture_finding.h"

namespace handgraft::retargeting {

hand::HandPose GoingAlong::goal(const hand::Hand& hand,
                                const Pose& X_OD,
                                const std::vector<contact::PartDirection>& posture,
                                const Eigen::VectorXd& lower,
                                const Eigen::VectorXd& upper) {
  if (!looked_q_) {
    looked_q_ = placement::jointsLike(hand, posture_, hand_O_.X_WH.linear(), hand_O_.q);
    looks_q_ = *looked_q_;
  }
  hand::HandPose goal;
  goal.X_WH = X_OD * inverse(X_OD_) * hand_O_.X_WH;
  looks_q_ = placement::jointsLike(hand, posture, goal.X_WH.linear(), looks_q_);
  goal.q = (hand_O_.q + looks_q_ - *looked_q_).cwiseMax(lower).cwiseMin(upper);
  return goal;
}

}  // namespace handgraft::retargeting
