#pragma once

#include <vector>

#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"

namespace handgraft::manipulation {

/// Some frames of a motion, as a motion, and what of the whole they are.
struct ThinnedMotion {
  Motion motion;
  std::vector<int> frames;             ///< of each of its frames: the whole motion's
  std::vector<std::vector<int>> keys;  ///< of each key of each track: likewise

  /// Whether it has every key of the whole, which are then the same by number.
  [[nodiscard]] bool hasAllKeys(const Motion& whole) const;
};

/// Every `stride`-th frame, those in which something appears, and the last one: all tracks are
/// there. Of keys that begin between two of them the last counts.
/// BrokenContract unless stride > 0. Cost: O(frames + keys).
ThinnedMotion thinned(const Motion& motion, int stride);

/// Lays each key of the whole motion where the thinned one has it; one that was left out where
/// the nearest key of its track is. Keys without a placement there stay as they are.
void takePlacements(const ThinnedMotion& thin, Motion& motion);

/// A pose of each frame of `motion`, by even steps between those of the thinned one.
std::vector<hand::HandPose> posesBetween(const ThinnedMotion& thin,
                                         const std::vector<hand::HandPose>& poses,
                                         const Motion& motion);

}  // namespace handgraft::manipulation
