#pragma once

#include <memory>

#include "core/contact/patch.h"
#include "core/geometry/log_mapper.h"
#include "core/hand/skin.h"
#include "core/hand/skin_planes.h"
#include "core/transfer/draft_charts.h"
#include "core/transfer/patch_chart.h"
#include "core/transfer/patch_transfer.h"
#include "core/transfer/skin_chart.h"

namespace handgraft::transfer {

/// The two surfaces of a transfer, with what log maps on them keep.
struct Surfaces {
  std::shared_ptr<const geometry::LogMapper> object_O;
  std::shared_ptr<const geometry::LogMapper> skin_S;  ///< of the skin's mesh
  std::shared_ptr<const hand::Skin> skin;
  /// Of that skin, by which drafts are projected; null: they are as others are.
  std::shared_ptr<const hand::SkinPlanes> planes_S = nullptr;
  /// Of that skin, on which drafts are laid; null: each has its own chart.
  std::shared_ptr<const DraftCharts> drafts_S = nullptr;
};

/// Borrows both, for as long as the result and charts made with it live.
Surfaces borrowedSurfaces(const geometry::TriangleMesh& object_O, const hand::Skin& skin);

/// The transfer of one patch that is laid again and again while it is edited: charts are made
/// anew only where what they depend on changed.
///
/// A root on the hand that moves makes the skin's chart anew, a root on the object the
/// object's (and the skin's, when the patch reaches farther than it does). A direction turns
/// coordinates and makes no log map. Results are those of `transferPatch`, bit for bit,
/// whatever was laid before. Copies share charts.
class StagedTransfer {
 public:
  /// Errors, frames: as `transferPatch`; an error leaves the charts as they were.
  /// A draft is for a search: where the options leave the method open, the skin's chart is made
  /// by the quick one or shared, and how well the shape is kept is not measured.
  PatchTransfer lay(const Surfaces& surfaces,
                    const contact::Patch& patch,
                    const PatchPlacement& placement,
                    const TransferOptions& options,
                    bool is_draft = false);

  /// Of the last transfer; missing before the first.
  [[nodiscard]] const std::shared_ptr<const PatchChart>& patchChart() const {
    return patch_chart_;
  }

  [[nodiscard]] const std::shared_ptr<const SkinChart>& skinChart() const {
    return skin_chart_;
  }

 private:
  std::shared_ptr<const PatchChart> patch_chart_;
  std::shared_ptr<const SkinChart> skin_chart_;
};

}  // namespace handgraft::transfer
