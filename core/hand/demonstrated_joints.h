#pragma once

#include <array>

#include <Eigen/Core>

namespace handgraft::hand {

/// Places of a human hand's joints: the wrist, then of thumb, index, middle, ring and little
/// each three joints from the knuckle on and the tip.
using JointPlaces = Eigen::Matrix<double, 3, 21>;

enum class HandSide { kRight, kLeft };

/// Entries of MANO's pose: the wrist's rotation vector, then those of index, middle, little,
/// ring and thumb, three each.
inline constexpr int kManoPoseSize = 48;

/// Where MANO's wrist is at rest, from its model's origin (m): its translation moves the
/// origin, so that the wrist of a pose lies at both together.
Eigen::Vector3d manoRestWrist(HandSide side);

/// The joints of MANO's mean hand in a pose: its own rotation vectors (rad), none of them
/// relative to a mean pose, and its translation (m), as MANO means it (manoRestWrist). A left
/// hand's are those of MANO's left model. Tips lie at the ends of the last bones.
/// Errors: InvalidInput if a joint of a finger turns by more than 2 pi: degrees.
/// Source: Romero, Tzionas & Black 2017, "Embodied Hands"; joints and lengths as in the MJCF of
/// the recorded sequences.
JointPlaces manoJointPlaces(const Eigen::Matrix<double, kManoPoseSize, 1>& pose_rad,
                            const Eigen::Vector3d& translation_W,
                            HandSide side);

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
