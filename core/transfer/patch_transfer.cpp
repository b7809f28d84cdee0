#include "core/transfer/patch_transfer.h"

#include <memory>

#include "core/base/error.h"
#include "core/transfer/staged_transfer.h"

namespace handgraft::transfer {

void validate(const TransferOptions& options) {
  if (options.interior_rings < 0 || options.interior_rings > kMostInteriorRings) {
    rejectInput("interior rings: {}; permitted are 0 to {}", options.interior_rings,
                kMostInteriorRings);
  }
}

PatchTransfer transferPatch(const geometry::TriangleMesh& object_O,
                            const contact::Patch& patch,
                            const hand::Skin& skin,
                            const PatchPlacement& placement,
                            const TransferOptions& options) {
  return StagedTransfer().lay(borrowedSurfaces(object_O, skin), patch, placement, options);
}

}  // namespace handgraft::transfer
