#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/hand/contact_site.h"
#include "core/hand/finger_coordinates.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"
#include "core/transfer/staged_transfer.h"

namespace handgraft::manipulation {

/// A motion's patches on a hand's skin.
struct TransferredMotion {
  std::vector<PairTrack> tracks;
  /// Of each entry of `tracks`: which of the motion's it is.
  std::vector<int> track_of;
  std::vector<std::string> notes;  ///< patches that found no place, and why
};

/// Where a key's patch goes on the hand: where it was found, else where the patch tells;
/// nothing if it has no place there.
std::optional<transfer::PatchPlacement> placementOf(const PatchKey& key,
                                                    const transfer::Surfaces& surfaces,
                                                    const hand::HandModel& model,
                                                    const std::vector<hand::ContactSite>& sites,
                                                    const hand::FingerCoordinates& coordinates);

/// Another place on the hand than a key's own.
using MovePlacement = std::function<transfer::PatchPlacement(const transfer::PatchPlacement&)>;

/// Charts of a motion whose patches are laid again and again while they move on the hand: those
/// that still hold are not made anew.
struct MotionCharts {
  std::vector<std::vector<transfer::StagedTransfer>> stages;  ///< by track and key
  bool uses_drafts = false;                                   ///< StagedTransfer::lay
};

/// Lays each key of each track: at the place on the hand that it tells, else at the site or in
/// the middle of the segment that its name tells; as transfer::transferPatch does. Patches
/// without a direction, or without a place on this hand, are left out and noted.
///
/// `charts`, if given, are those of the last time, and become this one's. Errors: InvalidInput
/// if none is left; Cancelled on wish. Cost: a log map on either side a key whose roots moved.
TransferredMotion transferPatches(const Motion& motion,
                                  const transfer::Surfaces& surfaces,
                                  const hand::HandModel& model,
                                  const std::vector<hand::ContactSite>& sites,
                                  const hand::FingerCoordinates& coordinates,
                                  const transfer::TransferOptions& options,
                                  const Progress& progress,
                                  const MovePlacement& move = MovePlacement(),
                                  MotionCharts* charts = nullptr);

}  // namespace handgraft::manipulation
