#pragma once

#include "core/hand/skin.h"
#include "core/optimize/pose_problem.h"
#include "core/transfer/patch_placement.h"

/// Places on a skin as another skin with the same faces has them (hand/skin_bending.h): a face
/// and barycentric weights mean the same on both.
namespace handgraft::sweep {

transfer::PatchPlacement carriedAlong(const hand::Skin& from,
                                      const hand::Skin& to,
                                      const transfer::PatchPlacement& placement);

/// A pair whose point goes with the skin next to it; as it was where that skin is of no link.
optimize::PointPair carriedAlong(const hand::Skin& from,
                                 const hand::Skin& to,
                                 optimize::PointPair pair);

}  // namespace handgraft::sweep
