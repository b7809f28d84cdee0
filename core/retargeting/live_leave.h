#pragma once

#include <optional>
#include <vector>

#include "core/base/pose.h"
#include "core/contact/contact_set.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"

namespace handgraft::retargeting {

/// Where a hand that follows goes while nothing touches: as the demonstrator's hand goes over
/// the object, from where both were when they last held it, and as it opens and closes. All
/// poses are in the object's frame, and X_OD is the demonstrator's hand.
class LiveLeave {
 public:
  /// Something touches: so the demonstrator's hand is held, and this one is there.
  void hold(const Pose& X_OD,
            const std::vector<contact::PartDirection>& posture,
            const hand::HandPose& hand_O) {
    held_ = Held{X_OD, posture, hand_O, {}};
  }

  [[nodiscard]] bool hasHeld() const { return held_.has_value(); }

  /// Nothing does: where `hand` goes, its joints within `lower` and `upper`. BrokenContract
  /// unless it has held. Cost: a posture (placement::postureFor); the first time two.
  [[nodiscard]] hand::HandPose goal(const hand::Hand& hand,
                                    const Pose& X_OD,
                                    const std::vector<contact::PartDirection>& posture,
                                    const Eigen::VectorXd& lower,
                                    const Eigen::VectorXd& upper);

 private:
  struct Held {
    Pose X_OD;
    std::vector<contact::PartDirection> posture;
    hand::HandPose hand_O;
    Eigen::VectorXd posture_q;  // on this hand; empty until it is asked for
  };

  std::optional<Held> held_;
};

}  // namespace handgraft::retargeting
