#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/transfer/patch_transfer.h"
#include "core/transfer/staged_transfer.h"

namespace handgraft::transfer {

struct SuggestOptions {
  double reach_m = 0.010;  ///< how far the root on the skin may move; 1e-4 to 0.1 m
  int count = 5;           ///< of suggestions at most; 1 to 100
};

/// Errors: InvalidInput names the value and its range.
void validate(const SuggestOptions& options);

/// One other placement of a patch and what would come of it.
struct Suggestion {
  PatchPlacement placement;
  double moved_m = 0.0;  ///< geodesic distance from the present root
  /// Of the direction, after `movedTo` carried it to the new root: turning that by this angle
  /// (`turned`) gives the placement's direction, bit for bit.
  double turned_rad = 0.0;
  PatchTransfer transfer;
};

/// Searches the neighbourhood of a patch's root on the skin for placements that lose fewer
/// points: fewest lost first, then least distortion of distances (in steps of 2 %), then least
/// change, by how far it moves the patch's outline. Only placements that lose fewer than the
/// present one, and differ from those before; empty if none does. Moves nothing.
///
/// Deterministic. Errors: InvalidInput for options out of range, and as `transferPatch`.
/// Cancelled on wish. Cost: if points are lost, some hundred log maps of the skin; the object's
/// is made once.
std::vector<Suggestion> suggestPlacements(const geometry::TriangleMesh& object_O,
                                          const contact::Patch& patch,
                                          const hand::Skin& skin,
                                          const PatchPlacement& present,
                                          const SuggestOptions& options,
                                          const TransferOptions& transfer_options,
                                          const Progress& progress);

/// The same with charts that are there already: those of the patch as it was laid last.
std::vector<Suggestion> suggestPlacements(const Surfaces& surfaces,
                                          StagedTransfer staged,
                                          const contact::Patch& patch,
                                          const PatchPlacement& present,
                                          const SuggestOptions& options,
                                          const TransferOptions& transfer_options,
                                          const Progress& progress);

}  // namespace handgraft::transfer
