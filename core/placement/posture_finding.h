#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/contact/contact_set.h"
#include "core/hand/hand.h"

namespace handgraft::placement {

/// How a hand stands where contacts leave it open.
struct Posture {
  Eigen::VectorXd q;                    ///< a value per dof, within the limits
  std::optional<Eigen::Matrix3d> R_OH;  ///< missing where nobody knows how the hand was held
  double sureness = 1.0;  ///< of weights: 1 to 64, for a hand that comes near to it
};

/// The posture of `hand` that has its parts turned most like those of the hand that touched:
/// segments and palm of the same names, by their bones and, half as much, by where they close
/// to. Joints that this leaves open, and all of them where `contacts` tell no posture, are
/// relaxed (hand::relaxedPosture).
///
/// Deterministic. Cost: some milliseconds.
Posture postureFor(const hand::Hand& hand, const contact::ContactSet& contacts);

/// The joints alone, of a hand that is turned as R_OH says, from `start` downhill: postures
/// that follow each other have joints that do. Deterministic. Cost: some 0.2 ms.
Eigen::VectorXd jointsLike(const hand::Hand& hand,
                           const std::vector<contact::PartDirection>& posture,
                           const Eigen::Matrix3d& R_OH,
                           const Eigen::VectorXd& start);

}  // namespace handgraft::placement
