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

/// The joints of MANO's mean hand in a pose: its own rotation vectors (rad), none of them
/// relative to a mean pose, and its translation (m). A left hand's are those of MANO's left
/// model. Tips lie at the ends of the last bones.
/// Source: Romero, Tzionas & Black 2017, "Embodied Hands"; joints and lengths as in the MJCF of
/// the recorded sequences.
JointPlaces manoJointPlaces(const Eigen::Matrix<double, kManoPoseSize, 1>& pose_rad,
                            const Eigen::Vector3d& translation_W,
                            HandSide side);

}  // namespace handgraft::hand
