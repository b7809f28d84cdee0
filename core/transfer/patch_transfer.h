#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/contact/contact_set.h"
#include "core/geometry/log_map.h"
#include "core/hand/skin.h"
#include "core/transfer/fidelity.h"
#include "core/transfer/patch_placement.h"

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

/// How patches are laid onto a skin.
struct TransferOptions {
  geometry::LogMapMethod method = geometry::LogMapMethod::kAuto;  ///< on both sides
  /// Shrunken copies of the boundary that are transferred, too: 0 to kMostInteriorRings, at
  /// equal shares of the way from the root.
  int interior_rings = 0;
};

inline constexpr int kMostInteriorRings = 16;

/// Errors: InvalidInput names the value and its range.
void validate(const TransferOptions& options);

struct LostPoint {
  int index = 0;  ///< into the patch's interpolation boundary
  int ring = 0;   ///< 0: the boundary itself; else interior, 1 the innermost
  std::string reason;
};

/// One patch laid onto the skin.
struct PatchTransfer {
  std::string name;
  /// Of the boundary first, in its order, then of the interior rings, the innermost first.
  std::vector<Correspondence> correspondences;
  int boundary_count = 0;  ///< the first of them, which lie on the boundary
  /// Places on the skin, one per correspondence, and where they are, in S: for pictures.
  std::vector<geometry::SurfacePoint> places_S;
  std::vector<Eigen::Vector3d> points_S;
  std::vector<LostPoint> lost;  ///< of the boundary, then of the rings
  Fidelity fidelity;
  /// Transferred points whose coordinates several sheets of a surface cover; the nearest sheet
  /// was taken.
  int folded = 0;
  bool root_is_outside = false;  ///< the patch's boundary does not go round its root
  bool is_draft = false;         ///< of a search (staged_transfer.h)
  /// That made the log maps, never kAuto.
  geometry::LogMapMethod method_O = geometry::LogMapMethod::kFast;
  geometry::LogMapMethod method_S = geometry::LogMapMethod::kFast;
};

/// Lays one patch onto the skin by log-map coordinates about both roots, mirrored (phi_h =
/// -phi_o), and projects it onto the links. One shot; StagedTransfer keeps what it computed.
///
/// Frames: patch and `object_O` in O; placement in S. `patch.direction_O` must be set
///   (BrokenContract).
/// Errors: InvalidInput for a direction parallel to the normal, a point off its mesh, or
///   options out of range. Points without a place are reported in `lost`, never clamped.
/// Cost: a log map on either side, O(n log n) in the patch.
/// Source: paper, Eq. 1. Differs: barycentric inverse lookup instead of the nearest vertex; the
///   mirror, since contact is face to face.
PatchTransfer transferPatch(const geometry::TriangleMesh& object_O,
                            const contact::Patch& patch,
                            const hand::Skin& skin,
                            const PatchPlacement& placement,
                            const TransferOptions& options = {});

}  // namespace handgraft::transfer
