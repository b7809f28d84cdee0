#pragma once

#include <vector>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::retargeting {

/// Pairs of no patch, without normals, that pull a hand to a pose: three points of each link,
/// so that each joint feels it. Frames: of `goal`, the problem's W. Cost: O(links).
std::vector<optimize::PointPair> pairsTo(const hand::HandModel& model,
                                         const hand::HandPose& goal,
                                         double weight);

}  // namespace handgraft::retargeting
