#include "core/transfer/placement.h"

#include "core/geometry/tangent.h"

namespace handgraft::transfer {

Placement placementAt(const hand::HandModel& model,
                      const hand::Skin& skin,
                      const hand::ContactSite& site) {
  const int link = model.linkIndex(site.link);
  Placement placement;
  placement.root_S = skin.skinPointOf(link, site.p_L);
  placement.direction_S = skin.directionInSkin(link, site.direction_L);
  return placement;
}

Placement movedTo(const geometry::TriangleMesh& skin_S,
                  const Placement& placement,
                  const geometry::SurfacePoint& root_S) {
  return {root_S, tangentCarried(skin_S, placement.root_S, root_S, placement.direction_S)};
}

Placement turned(const geometry::TriangleMesh& skin_S,
                 const Placement& placement,
                 double angle_rad) {
  return {placement.root_S,
          tangentTurned(skin_S, placement.root_S, placement.direction_S, angle_rad)};
}

}  // namespace handgraft::transfer
