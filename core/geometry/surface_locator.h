#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// Finds the nearest place of one mesh to a point in space: a tree of boxes over its triangles,
/// so the answer is the exact nearest triangle, not the nearest vertex.
///
/// Zero-area faces count as the segments they are. Ties go to the lowest face. Keeps its own
/// copy of the mesh. Queries are const and may run on several threads.
class SurfaceLocator {
 public:
  /// Errors: InvalidInput if the mesh has no face. Cost: O(F log F).
  explicit SurfaceLocator(const TriangleMesh& mesh);
  ~SurfaceLocator();
  SurfaceLocator(SurfaceLocator&&) noexcept;
  SurfaceLocator& operator=(SurfaceLocator&&) noexcept;

  struct Hit {
    SurfacePoint point;
    Eigen::Vector3d position;
    double distance = 0.0;
  };

  /// Frames: `p` in the mesh's own frame. Errors: InvalidInput if `p` is not finite.
  /// Cost: O(log F) for points near the surface.
  [[nodiscard]] Hit nearest(const Eigen::Vector3d& p) const;

  /// The same, or nothing beyond `reach`, and sooner. Errors: InvalidInput if `p` is not
  /// finite.
  [[nodiscard]] std::optional<Hit> nearest(const Eigen::Vector3d& p, double reach) const;

  /// Fills `faces` with those whose own boxes touch `box`, in no particular order.
  void facesTouching(const Eigen::AlignedBox3d& box, std::vector<int>& faces) const;

  [[nodiscard]] const TriangleMesh& mesh() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace handgraft::geometry
