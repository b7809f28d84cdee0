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

/// A side opposite to the source, as the source sees it across one face.
struct SourceWedge {
  int halfedge = -1;  ///< of the source's face, counter-clockwise about the source
  /// Its ends, in a plane whose origin is the source.
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  /// An angle in that plane is phi = base + scale * angle.
  double base = 0.0;
  double scale = 1.0;
};

/// The surface around the source, laid flat.
struct SourceLayout {
  int vertex = -1;  ///< the vertex that the source stands on, or -1
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// Axes of T in the mesh's frame: x along the projected direction, y to its left.
  Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  std::vector<int> faces;
  std::vector<SourceNeighbour> neighbours;
  std::vector<SourceWedge> wedges;
};

/// The halfedge of its face that a place between two vertices lies on, if there is a face on
/// the other side; else -1: then the plane T of the place is its face's.
int innerHalfedgeAt(const TriangleMesh& mesh, const SurfacePoint& point);

/// Lays the faces around `source` into its tangent plane T, whose x axis is the projection of
/// `direction`. README of this folder: which plane that is at a face, an edge and a vertex.
///
/// Errors: InvalidInput if the direction is not finite, zero or (nearly) normal to the surface,
/// or if the surface has no normal there.
SourceLayout layOutSource(const TriangleMesh& mesh,
                          const SurfacePoint& source,
                          const Eigen::Vector3d& direction);

}  // namespace handgraft::geometry
