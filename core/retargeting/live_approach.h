#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/hand/grip_point.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/contact_tracker.h"

namespace handgraft::retargeting {

/// Where a hand is before it has held anything: turned, opened and closed as the demonstrator's
/// hand is, and with its grip point where that one's is. What touches says nothing yet; as
/// hands come near they are so about where they will hold the object. Frames: O.
class LiveApproach {
 public:
  /// Nothing where it is not told how the demonstrator's hand is held, or the hand has no
  /// digits. Cost: some milliseconds.
  static std::optional<LiveApproach> from(const hand::Hand& hand,
                                          const manipulation::ShownHand& shown);

  /// Joints within `lower` and `upper`. Nothing where `shown` does not tell it. Cost: some
  /// 0.2 ms if the posture is like the one asked for last.
  std::optional<hand::HandPose> goal(const manipulation::ShownHand& shown,
                                     const Eigen::VectorXd& lower,
                                     const Eigen::VectorXd& upper);

 private:
  LiveApproach(const hand::Hand& hand, const Eigen::Matrix3d& R_DH, Eigen::VectorXd q)
      : hand_(hand), grip_(hand), R_DH_(R_DH), q_(std::move(q)) {}

  hand::Hand hand_;
  hand::GripPoint grip_;
  Eigen::Matrix3d R_DH_;  ///< the hand turned as the demonstrator's palm is
  Eigen::VectorXd q_;     ///< as last asked for
};

}  // namespace handgraft::retargeting
