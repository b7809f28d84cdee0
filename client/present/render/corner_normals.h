#pragma once

#include <vector>

#include <Eigen/Core>

#include "client/present/render/scene.h"

namespace handgraft::client::render {

/// Normals for smooth shading, three per triangle in the order of its corners: the mean of the
/// faces around the corner, weighted by area, that lie within `crease_rad` of the triangle's
/// own. Round things look round and the edges of boxes stay sharp. Vertices at the same place
/// count as one. Corners of triangles without area get the zero vector.
///
/// Cost: linear in the number of triangles times the faces around a vertex.
std::vector<Eigen::Vector3f> cornerNormals(const SurfaceMesh& mesh, double crease_rad);

}  // namespace handgraft::client::render
