#pragma once

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// How large a thing is, whatever specks a scan left far from it: the diagonal of the box that
/// holds nearly all of its surface where that of all of it is much longer, else that of all.
///
/// Units: the mesh's. Cost: O(V log V).
double mainExtent(const TriangleMesh& mesh);

/// The same of points that weigh alike (3 x N). NaN if one is not finite.
double mainExtent(const Eigen::Matrix3Xd& points);

}  // namespace handgraft::geometry
