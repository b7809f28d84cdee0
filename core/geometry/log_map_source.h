#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// A vertex next to the source, seen from it along a straight line inside one or two faces.
struct SourceNeighbour {
  int vertex = -1;
  double r = 0.0;
  /// Unit vector in the source's tangent plane T; (r * direction_T) are log coordinates.
  Eigen::Vector2d direction_T = Eigen::Vector2d::UnitX();
};

/// The surface around the source, laid flat.
struct SourceLayout {
  int vertex = -1;  ///< the vertex that the source stands on, or -1
  std::vector<int> faces;
  std::vector<SourceNeighbour> neighbours;
};

/// Lays the faces around `source` into its tangent plane T, whose x axis is the projection of
/// `direction`. README of this folder: which plane that is at a face, an edge and a vertex.
///
/// Errors: InvalidInput if the direction is not finite, zero or (nearly) normal to the surface,
/// or if the surface has no normal there.
SourceLayout layOutSource(const TriangleMesh& mesh,
                          const SurfacePoint& source,
                          const Eigen::Vector3d& direction);

}  // namespace handgraft::geometry
