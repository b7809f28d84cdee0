#pragma once

#include <Eigen/Core>

#include "core/hand/demonstrated_joints.h"

namespace handgraft::hand {

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

}  // namespace handgraft::hand
