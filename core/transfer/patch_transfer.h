#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/contact/contact_set.h"
#include "core/geometry/log_map.h"
#include "core/hand/contact_site.h"
#include "core/hand/skin.h"

namespace handgraft::transfer {

/// One pair of points that the optimiser brings together.
struct Correspondence {
  int link = -1;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
  double weight = 1.0;  ///< of its patch
  int patch = 0;        ///< index into the transferred patches, set by who transfers several
};

/// Where a patch goes on the hand: two of the paper's four choices.
struct Placement {
  geometry::SurfacePoint root_S;  ///< on the skin
  Eigen::Vector3d direction_S = Eigen::Vector3d::Zero();
};

struct LostPoint {
  int index = 0;  ///< into the patch's interpolation boundary
  std::string reason;
};

/// One patch laid onto the skin.
struct PatchTransfer {
  std::string name;
  std::vector<Correspondence> correspondences;
  /// Outline on the skin, in S, one per correspondence, for pictures.
  std::vector<Eigen::Vector3d> points_S;
  std::vector<LostPoint> lost;
  /// How much the distances from the root changed: mean |r_hand / r_obj - 1|, with r_hand the
  /// geodesic distance on the skin to the place nearest to the point's projection onto its
  /// link; 0 where nothing was reached.
  double distance_distortion = 0.0;
};

/// Lays one patch onto the skin by log-map coordinates about both roots, mirrored (phi_h =
/// -phi_o), and projects it onto the links.
///
/// Frames: patch and `object_O` in O; placement in S. `patch.direction_O` must be set
///   (BrokenContract).
/// Errors: InvalidInput for a direction parallel to the normal or a point off its mesh. Points
///   without a place are reported in `lost`, never clamped.
/// Cost: two log maps of the patch's disk, O(n log n).
/// Source: paper, Eq. 1. Differs: barycentric inverse lookup instead of the nearest vertex; the
///   mirror (DESIGN 3.1), since contact is face to face.
PatchTransfer transferPatch(const geometry::TriangleMesh& object_O,
                            const contact::Patch& patch,
                            const hand::Skin& skin,
                            const Placement& placement,
                            geometry::LogMapMethod method = geometry::LogMapMethod::kFast);

/// The placement at a site of the hand.
Placement placementAt(const hand::HandModel& model,
                      const hand::Skin& skin,
                      const hand::ContactSite& site);

}  // namespace handgraft::transfer
