#pragma once

#include <Eigen/Core>

#include "core/contact/patch.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::manipulation {

/// A patch on its way over a surface: its root goes the shortest way, its direction along by
/// parallel transport (and by and by to that of the end), its outline by log-map coordinates
/// between those that it has at both ends. Points keep their identity.
///
/// Frames: the mesh's own. Errors: InvalidInput if the ends have different numbers of points,
/// one has no direction, or no way over the surface leads from one to the other.
/// Cost: two log maps to make, one for each question.
/// Source: paper, "Extension to Manipulations".
class PatchPath {
 public:
  /// Keeps a reference to the mesh.
  PatchPath(const geometry::TriangleMesh& mesh,
            const contact::Patch& from,
            const contact::Patch& to);

  /// Where it is at a share of the way, 0 to 1. Points that find no place by their coordinates
  /// go to the nearest place of the surface. The ends are as they were given.
  [[nodiscard]] contact::Patch at(double share) const;

  /// m, of the root.
  [[nodiscard]] double length() const { return way_T_.norm(); }

 private:
  [[nodiscard]] geometry::SurfacePoint rootAt(double share) const;
  /// Tangent of the way there.
  [[nodiscard]] Eigen::Vector3d headingAt(double share) const;

  const geometry::TriangleMesh& mesh_;
  contact::Patch from_;
  contact::Patch to_;
  geometry::SurfaceLocator locator_;
  std::vector<geometry::SurfacePoint> way_;  ///< places at equal shares, the ends among them
  Eigen::Vector2d way_T_ = Eigen::Vector2d::Zero();  ///< of the end, about the first root
  double turn_rad_ = 0.0;    ///< what transport leaves between the directions
  Eigen::Matrix2Xd from_T_;  ///< outlines about their own roots
  Eigen::Matrix2Xd to_T_;
};

/// The patch with its root `shift_T` away in log coordinates about it (x along its direction),
/// and outline and direction carried along: what a finger that slides leaves.
/// Errors: InvalidInput if there is no surface there, or the patch has no direction.
contact::Patch slid(const geometry::TriangleMesh& mesh,
                    const contact::Patch& patch,
                    const Eigen::Vector2d& shift_T);

}  // namespace handgraft::manipulation
