#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// The mesh as the border of a solid, so that every place has a whole winding number.
///
/// Vertices at one place become one; neighbours that disagree about the outside are turned to
/// the majority (by area) of their component; every hole is shut by a fan about the middle of
/// its rim. As a chain of triangles the result has no border at all, whatever the mesh was:
/// unoriented, non-manifold, open. The faces of `mesh` come first, but for those without three
/// different corners.
///
/// Limits: a cup without thickness is filled up to its rim, a flat sheet holds nothing, and a
/// mesh turned inside out as a whole stays so. Cost: O(F log F).
TriangleMesh closedSurface(const TriangleMesh& mesh);

/// A mesh as borders of solids, and what borders none.
struct SolidsAndSheets {
  TriangleMesh mesh;    ///< the solids' faces first
  int solid_faces = 0;  ///< so many; the others are sheets, open to both sides
  /// Which of the given faces each one is, -1 for what shuts a hole.
  std::vector<int> given_face;
  /// Of each: 1 where its second and third corner have changed places.
  std::vector<char> is_turned;
};

/// As `closedSurface`, but holes wider than `widest_hole_m` (the diameter of a disc of the same
/// area) stay open: what hangs together with their rims is a sheet that has no inside, be it a
/// cup or a blanket.
SolidsAndSheets solidsAndSheets(const TriangleMesh& mesh, double widest_hole_m);

}  // namespace handgraft::geometry
