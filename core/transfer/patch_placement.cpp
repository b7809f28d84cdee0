#include "core/transfer/patch_placement.h"

#include "core/geometry/tangent.h"

namespace handgraft::transfer {

PatchPlacement placementAt(const hand::HandModel& model,
                           const hand::Skin& skin,
                           const hand::ContactSite& site) {
  const int link = model.linkIndex(site.link);
  PatchPlacement placement;
  placement.root_S = skin.skinPointOf(link, site.p_L);
  placement.direction_S = skin.directionInSkin(link, site.direction_L);
  return placement;
}

PatchPlacement movedTo(const geometry::TriangleMesh& skin_S,
                       const PatchPlacement& placement,
                       const geometry::SurfacePoint& root_S) {
  return {root_S, tangentCarried(skin_S, placement.root_S, root_S, placement.direction_S)};
}

PatchPlacement turned(const geometry::TriangleMesh& skin_S,
                      const PatchPlacement& placement,
                      double angle_rad) {
  return {placement.root_S,
          tangentTurned(skin_S, placement.root_S, placement.direction_S, angle_rad)};
}

}  // namespace handgraft::transfer
