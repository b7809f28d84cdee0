#pragma once

#include <vector>

#include "core/hand/digits.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

// Which way digits close: part of findDigits (digits.h), which says by what it is told.

/// Cosine; joints whose axes lean less than that from each other bend a finger the same way.
inline constexpr double kBendAlike = 0.8;

/// Gives digits that have their joints and tips the axis and the side to which they close.
/// Those of which nothing tells it are erased. Cost: some microseconds a digit.
void orientDigits(const HandModel& model, const LinkPoses& X_SL, std::vector<Digit>& digits);

/// Of two digits each closes towards the other, whatever their limits say: a gripper may be
/// shut where its joints are 0. Others stay as they are.
void orientPair(const HandModel& model, const LinkPoses& X_SL, std::vector<Digit>& digits);

}  // namespace handgraft::hand
