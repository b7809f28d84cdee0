#pragma once

#include <cstddef>
#include <vector>

#include "core/placement/hand_pose_guess.h"

namespace handgraft::placement {

/// The best ways to lay patches of unknown fingers onto sites, at most `most` of them, the best
/// one first: for every patch the site's index, or -1 for those that find none. Always one.
///
/// Looks through all assignments of the first `kMostAssigned` patches to the first
/// `kMostCandidates` sites (as many patches as can be, in their order), keeps those whose roots
/// and normals a rigid hand meets best, and compares these by short solves, the best of them
/// from several starts, and by depth inside the object. `fixed` are anchors that already know
/// their place. Deterministic.
///
/// Shapes: patches_O holds the object sides, sites_L the hand sides; permitted(p, s) row by
/// row. Cost: about 20 us an assignment plus 0.2 s.
std::vector<std::vector<int>> assignSites(const HandPoseGuesser& placer,
                                          const std::shared_ptr<const hand::HandModel>& model,
                                          const std::vector<Anchor>& fixed,
                                          const std::vector<Anchor>& patches_O,
                                          const std::vector<Anchor>& sites_L,
                                          const std::vector<std::vector<bool>>& permitted,
                                          const Pose& X_WO,
                                          std::size_t most,
                                          const Progress& progress);

inline constexpr int kMostAssigned = 6;
inline constexpr int kMostCandidates = 7;

}  // namespace handgraft::placement
