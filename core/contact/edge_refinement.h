#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// Vertices that a refinement may end with at most; bounds memory on objects of metres.
inline constexpr int kMostRefinedVertices = 2'000'000;

/// The same surface with no edge longer than `longest_edge_m`: long edges are halved, and the
/// faces on either side cut alike, until none is left. The first vertices are those of `mesh`.
///
/// A face whose three edges are long falls into four similar ones; others are cut from the
/// middle of their longest edge, so that angles do not collapse. Errors: InvalidInput unless
/// the length is above 0, or if more than kMostRefinedVertices would be needed. Cost: O(F log
/// F) of the result. `parents`, if given, takes the face of `mesh` that each face lies in.
geometry::TriangleMesh refineEdges(const geometry::TriangleMesh& mesh,
                                   double longest_edge_m,
                                   std::vector<int>* parents = nullptr);

}  // namespace handgraft::contact
