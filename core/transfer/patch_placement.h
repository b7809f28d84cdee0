#pragma once

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/contact_site.h"
#include "core/hand/skin.h"

namespace handgraft::transfer {

/// Where a patch goes on the hand: two of the paper's four choices.
struct PatchPlacement {
  geometry::SurfacePoint root_S;  ///< on the skin
  Eigen::Vector3d direction_S = Eigen::Vector3d::Zero();
};

/// The placement at a site of the hand.
PatchPlacement placementAt(const hand::HandModel& model,
                           const hand::Skin& skin,
                           const hand::ContactSite& site);

/// The placement with its root at `root_S`; the direction comes along by the smallest rotation
/// between the two normals.
PatchPlacement movedTo(const geometry::TriangleMesh& skin_S,
                       const PatchPlacement& placement,
                       const geometry::SurfacePoint& root_S);

/// The placement with its direction turned about the normal, counter-clockwise seen from
/// outside.
PatchPlacement turned(const geometry::TriangleMesh& skin_S,
                      const PatchPlacement& placement,
                      double angle_rad);

}  // namespace handgraft::transfer
