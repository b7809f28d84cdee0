#pragma once

#include <random>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::bench {

/// A mesh with points put into its faces, and where each new vertex (those behind the old ones)
/// stood in the old mesh.
struct NeedledMesh {
  geometry::TriangleMesh mesh;
  std::vector<geometry::SurfacePoint> added;
};

/// Splits every second face, drawn from `random`, at a point 1/100 of its height off the middle
/// of one of its edges.
NeedledMesh withNeedles(const geometry::TriangleMesh& mesh, std::mt19937& random);

/// Flips edges between pairs of faces, each face in one pair at most, where the flip makes both
/// faces obtuse and the two lie convex in their common plane.
geometry::TriangleMesh flippedToObtuse(const geometry::TriangleMesh& mesh);

/// Share of the faces that have an angle above 90 degrees.
double obtuseShare(const geometry::TriangleMesh& mesh);

}  // namespace handgraft::bench
