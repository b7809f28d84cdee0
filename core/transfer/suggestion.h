#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/transfer/patch_transfer.h"

namespace handgraft::transfer {

struct SuggestOptions {
  double reach_m = 0.010;  ///< how far the root on the skin may move; 1e-4 to 0.1 m
  int count = 5;           ///< of suggestions; 1 to 100
};

/// One other placement of a patch and what would come of it.
struct Suggestion {
  Placement placement;
  double moved_m = 0.0;     ///< geodesic distance from the present root
  double turned_rad = 0.0;  ///< against the present direction carried to the new root
  PatchTransfer transfer;
};

/// Searches the neighbourhood of a patch's root on the skin for placements that lose fewer
/// points: fewest lost first, then least distortion, then least change. Only placements better
/// than the present one; empty if none is. Moves nothing. Deterministic.
std::vector<Suggestion> suggestPlacements(const geometry::TriangleMesh& object_O,
                                          const contact::Patch& patch,
                                          const hand::Skin& skin,
                                          const Placement& present,
                                          const SuggestOptions& options,
                                          const Progress& progress);

}  // namespace handgraft::transfer
