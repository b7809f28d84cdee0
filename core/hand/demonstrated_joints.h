#pragma once

#include <Eigen/Core>

namespace handgraft::hand {

/// Places of a human hand's joints: the wrist, then of thumb, index, middle, ring and little
/// each three joints from the knuckle on and the tip.
using JointPlaces = Eigen::Matrix<double, 3, 21>;

enum class HandSide { kRight, kLeft };

/// How far the four fingers are bent beyond their knuckles, in the mean (rad): some 0.1 of a
/// flat hand, 0.7 of one that holds something. Below 0 they bend backwards, as those of a
/// mirrored hand seem to. No sense for joints that lie at one place.
double fingerBend(const JointPlaces& joints, HandSide side);

/// Refuses what is no hand: one not as large as any (other units than metres), joints in
/// another order, a segment longer than any, fingers that bend backwards (the other side's
/// hand). Of one frame alone: what noise of 3 mm does to a child's hand is still a hand.
/// Errors: InvalidInput saying what seems to be wrong.
void requireHand(const JointPlaces& joints, HandSide side);

}  // namespace handgraft::hand
