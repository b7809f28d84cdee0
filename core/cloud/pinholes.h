#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::cloud {

/// The vertices around every hole of a mesh, as its faces run along it; a hole that touches
/// itself at a vertex counts as two. Cost: O(V + F).
std::vector<std::vector<int>> borderLoops(const geometry::TriangleMesh& mesh);

/// Greatest distance between two vertices of a loop.
double widthOf(const geometry::TriangleMesh& mesh, const std::vector<int>& loop);

/// A mesh whose small holes are closed, without new vertices.
struct Mended {
  geometry::TriangleMesh mesh;
  int closed = 0;
  double widest = 0.0;  ///< of those closed, in the mesh's unit
};

/// Closes the holes that are at most `widest` wide and have at most 24 edges, each with the
/// triangles of least area (Barequet & Sharir 1995), faces agreeing with those around. Holes
/// that cannot be closed without a third face at an edge stay. Cost: O(V + F), and the cube of
/// the edges of a hole.
Mended closePinholes(const geometry::TriangleMesh& mesh, double widest);

}  // namespace handgraft::cloud
