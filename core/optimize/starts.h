#pragma once

#include "core/optimize/moment_tree.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// How a start of a multi-start is made. All but the first put the root where the closed form
/// wants it for their joints.
enum class StartKind {
  kOwn,      ///< 0: the problem's own start as it is
  kAligned,  ///< 1, 2, 3: the start's, the prior's and the rest pose's joints
  kNear,     ///< joints about the start's, within a third of their ranges
  kCurled,   ///< all joints from the start towards their upper limits alike, a little uneven
  kTurned,   ///< spread joints, the root turned by a half or a quarter about an axis of W
  kSpread,   ///< joints of a low-discrepancy sequence between their bounds
};

/// From start 4 on the last four kinds take turns, turned ones twice as often.
StartKind startKind(int index);

/// The start of number `index`. Locked joints stay.
///
/// Joints without limits range over a right angle to both sides of the start, prismatic ones
/// over 5 cm. The same problem, index and seed give the same pose. Cost: O(links).
/// Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences" (R_d).
hand::HandPose startPose(const PoseProblem& problem,
                         const MomentTree& tree,
                         int index,
                         unsigned seed);

/// Start `index` about a pose that was found: a third of the joints moved, anywhere in their
/// ranges at most, and the root where the closed form wants it. Where many minima lie together,
/// the best of them is found from its neighbours sooner than from afar.
hand::HandPose startAbout(const hand::HandPose& found,
                          const PoseProblem& problem,
                          const MomentTree& tree,
                          int index,
                          unsigned seed);

}  // namespace handgraft::optimize
