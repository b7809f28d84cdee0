#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::cloud {

/// Indices of vertices, in no particular sense.
using Triangles = std::vector<std::array<int, 3>>;

/// The mesh of triangles, turned so that those of a component agree with its first one; edges
/// of more than two triangles end a component. Cost: O(T log T).
geometry::TriangleMesh orientedMesh(const std::vector<Eigen::Vector3d>& vertices,
                                    Triangles triangles);

}  // namespace handgraft::cloud
