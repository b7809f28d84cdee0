#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// Faces of a mesh that hang together through edges.
using Region = std::vector<int>;

/// Splits the marked faces into regions, in the order of their first faces.
/// Shapes: `marked` one flag per face. Cost: O(F).
std::vector<Region> connectedRegions(const geometry::TriangleMesh& mesh,
                                     const std::vector<char>& marked);

struct OuterBoundary {
  /// The longest simple loop around the region, the region on its left; empty if it has none,
  /// as a closed surface that is marked whole.
  std::vector<int> loop;
  /// Other loops: holes, and what was cut off where the boundary touches itself.
  int other_loops = 0;
};

/// Walks around a region. A boundary that meets itself in a vertex is split there into simple
/// loops. Cost: O(region).
OuterBoundary outerBoundary(const geometry::TriangleMesh& mesh, const Region& region);

/// The vertex inside the region whose farthest place on `loop` is nearest, by paths along the
/// region's edges and straight across pairs of its faces; a vertex of the loop only if there is
/// no other. Ties go to the smaller mean, then to the lowest index. Cost: O(n log n) in the
/// region's vertices.
int geodesicCentre(const geometry::TriangleMesh& mesh,
                   const Region& region,
                   const std::vector<int>& loop);

}  // namespace handgraft::contact
