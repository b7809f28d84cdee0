#pragma once

#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// The start of number `index` of a multi-start: 0 the problem's own, 1 its joints under the
/// closed-form alignment of the root, the others joints of a low-discrepancy sequence between
/// the bounds under that alignment. Locked joints stay.
///
/// Joints without limits range over a right angle to both sides of the start, prismatic ones
/// over 5 cm. The same problem, index and seed give the same pose. Cost: O(links + pairs).
/// Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences" (R_d).
hand::HandPose startPose(const PoseProblem& problem, int index, unsigned seed);

}  // namespace handgraft::optimize
