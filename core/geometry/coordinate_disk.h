#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/log_map.h"

namespace handgraft::geometry {

/// The disk of a log map out of coordinates known all over the surface.
///
/// Spreads face by face from the source's own faces over those that reach into the radius.
/// Faces with an unknown corner (NaN), or with one whose r is shorter than nine tenths of the
/// straight line from the source (no geodesic is: it lies at the cut locus, where averaged
/// coordinates cancel), are left out and not crossed.
///
/// Shapes: p_T 2 x V, log coordinates in the source's tangent plane, metres.
/// Cost: O(n log n) in the vertices of the disk, plus one O(V + F) fill.
LogMap diskFromCoordinates(const TriangleMesh& mesh,
                           const Eigen::Matrix2Xd& p_T,
                           const SurfacePoint& source,
                           const std::vector<int>& source_faces,
                           double radius);

}  // namespace handgraft::geometry
