#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/surface_locator.h"
#include "core/geometry/triangle_mesh.h"
#include "core/geometry/winding_number.h"

namespace handgraft::bench {

/// A body measured by its triangles alone: no grid, no cells, none of the samples that a solver
/// works with. Const and safe from several threads.
class ExactSolid {
 public:
  /// `standoff_m`: how far the mesh stands off the body that it is laid around.
  /// Samples are no farther apart than `spacing_m` along the surface.
  ExactSolid(const geometry::TriangleMesh& mesh, double spacing_m, double standoff_m = 0.0);

  /// How far `p` lies inside, m; 0 outside. Inside is where the surface winds round by more
  /// than half; an open mesh has no inside.
  [[nodiscard]] double depth(const Eigen::Vector3d& p) const;

  /// To the surface, from either side, m.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const;

  /// Corners, and places between them on an even grid of each triangle.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& samples() const { return samples_; }

  [[nodiscard]] const Eigen::AlignedBox3d& box() const { return box_; }

  /// Middles of the cells, of this edge, that lie inside.
  [[nodiscard]] std::vector<Eigen::Vector3d> cells(double edge_m) const;

  [[nodiscard]] const geometry::SurfaceLocator& locator() const { return *locator_; }

 private:
  std::unique_ptr<geometry::SurfaceLocator> locator_;
  std::unique_ptr<geometry::WindingNumber> winding_;  ///< null for an open mesh
  std::vector<Eigen::Vector3d> samples_;
  Eigen::AlignedBox3d box_;
  double standoff_m_ = 0.0;
};

}  // namespace handgraft::bench
