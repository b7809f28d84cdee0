#pragma once

#include <memory>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::bench {

/// CGAL's exact geodesic distances (Surface_mesh_shortest_path: Xin & Wang's windows over the
/// whole mesh; it knows no radius). Distances alone, no directions.
class CgalShortestPaths {
 public:
  /// Errors: InvalidInput for a mesh that is not manifold.
  explicit CgalShortestPaths(const geometry::TriangleMesh& mesh);
  ~CgalShortestPaths();
  CgalShortestPaths(const CgalShortestPaths&) = delete;
  CgalShortestPaths& operator=(const CgalShortestPaths&) = delete;

  /// Builds the tree of windows about `source`, as CGAL's manual has it; then `distanceTo`
  /// reads.
  void build(const geometry::SurfacePoint& source);

  /// NaN where nothing was reached.
  [[nodiscard]] double distanceTo(int vertex);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// CGAL's heat method on its intrinsic Delaunay triangulation, factored by the constructor.
/// Distances alone, from vertices.
class CgalHeatMethod {
 public:
  explicit CgalHeatMethod(const geometry::TriangleMesh& mesh);
  ~CgalHeatMethod();
  CgalHeatMethod(const CgalHeatMethod&) = delete;
  CgalHeatMethod& operator=(const CgalHeatMethod&) = delete;

  /// Of all vertices of the mesh.
  [[nodiscard]] Eigen::VectorXd distancesFrom(int vertex);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace handgraft::bench
