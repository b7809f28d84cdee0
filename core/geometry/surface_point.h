#pragma once

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// A place on a mesh: a face and barycentric weights of its corners (non-negative, sum 1). A
/// vertex is a point of any of its faces; code that cares asks `vertexAt`.
struct SurfacePoint {
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();

  [[nodiscard]] bool valid() const { return face >= 0; }
};

/// The corner-th vertex of some face of `vertex`. InvalidInput if the vertex does not exist or
/// has no face.
SurfacePoint surfacePointAtVertex(const TriangleMesh& mesh, int vertex);

/// The vertex this point stands on (a weight above 1 - 1e-9), or -1.
int vertexAt(const TriangleMesh& mesh, const SurfacePoint& point);

/// Throws InvalidInput, naming `what`, unless the face exists and the weights are finite,
/// non-negative and sum to 1 within 1e-6.
void validate(const TriangleMesh& mesh, const SurfacePoint& point, const char* what);

Eigen::Vector3d positionOf(const TriangleMesh& mesh, const SurfacePoint& point);

/// Unit normal interpolated from the vertex normals; the face's where they cancel.
Eigen::Vector3d normalOf(const TriangleMesh& mesh, const SurfacePoint& point);

}  // namespace handgraft::geometry
