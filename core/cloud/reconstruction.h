#pragma once

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/geometry/triangle_mesh.h"

/// Surfaces through points, by CGAL. What to make of them is `point_cloud_surface.h`'s concern.
/// Built without it (HANDGRAFT_WITH_CGAL=OFF) all throw InvalidInput.
///
/// Points are distinct, finite and no plane; all work in the points' own frame and unit, and
/// throw Cancelled between their steps. The same points give the same bytes (of Poisson:
/// where they are even, see README).
namespace handgraft::cloud {

/// Unit normals of fitted paraboloids, neighbours turned to agree (Hoppe et al. 1992); which
/// side they look to is open. Shapes: points 3 x N, `neighbours` 6 to N - 1, result 3 x N.
/// Cost: O(N log N).
Eigen::Matrix3Xd estimateNormals(const Eigen::Matrix3Xd& points,
                                 int neighbours,
                                 const Progress& progress);

/// The closed surface whose inside best agrees with oriented normals (Kazhdan, Bolitho & Hoppe
/// 2006, on a Delaunay refinement), faces outward. It smooths noise, and closes what is open.
///
/// `spacing`: mean distance of neighbours; `edge`: wanted length of edges. Without a face if
/// the solve or the meshing fails. May have several components. Cost: about 0.2 ms a point.
geometry::TriangleMesh poissonSurface(const Eigen::Matrix3Xd& points,
                                      const Eigen::Matrix3Xd& normals,
                                      double spacing,
                                      double edge,
                                      const Progress& progress);

/// The points themselves, joined by Delaunay triangles that continue each other best (Cohen-
/// Steiner & Da 2004): open where the points are, manifold and oriented, the side left open.
///
/// Vertices are the points, 3 x N, also those left out, which have no face. `longest_edge`: no
/// triangle has a longer one. Cost: O(N log N), about 0.02 ms a point.
geometry::TriangleMesh advancingFrontSurface(const Eigen::Matrix3Xd& points,
                                             double longest_edge,
                                             const Progress& progress);

}  // namespace handgraft::cloud
