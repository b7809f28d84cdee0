#pragma once

#include <optional>
#include <vector>

#include "core/base/pose.h"
#include "core/contact/contact_set.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"

namespace handgraft::retargeting {

/// Where a hand goes while nothing touches: as the demonstrator's hand goes over the object,
/// from where both were when something held it, and as that one opens and closes. All poses are
/// in the object's frame, and X_OD is any frame fixed to the demonstrator's palm.
class GoingAlong {
 public:
  /// Both as they are when something holds.
  GoingAlong(const Pose& X_OD,
             std::vector<contact::PartDirection> posture,
             const hand::HandPose& hand_O)
      : X_OD_(X_OD), posture_(std::move(posture)), hand_O_(hand_O) {}

  /// Where `hand` goes, its joints within `lower` and `upper`. They change by as much as those
  /// that look most like the posture do: what holds the object looks otherwise on this hand.
  /// Cost: some 0.2 ms if the posture is like the one asked for last.
  [[nodiscard]] hand::HandPose goal(const hand::Hand& hand,
                                    const Pose& X_OD,
                                    const std::vector<contact::PartDirection>& posture,
                                    const Eigen::VectorXd& lower,
                                    const Eigen::VectorXd& upper);

 private:
  Pose X_OD_;
  std::vector<contact::PartDirection> posture_;
  hand::HandPose hand_O_;
  /// Joints that look most like the posture, then and when last asked; none before.
  std::optional<Eigen::VectorXd> looked_q_;
  Eigen::VectorXd looks_q_;
};

}  // namespace handgraft::retargeting
