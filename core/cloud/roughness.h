#pragma once

#include <Eigen/Core>

#include "core/geometry/kd_tree.h"

namespace handgraft::cloud {

/// How far points are from where their neighbours put them: the median distance, along the
/// normal, of a point from the paraboloid through its 18 neighbours, itself left out. Noise
/// shows in it; curvature and, while most points are on no edge, sharp edges do not.
///
/// Shapes: points and unit normals (either side) 3 x N, N >= kFewestPoints; `tree` is of the
/// points. Judged by at most 4000 points, evenly picked. Units: the points'. Cost: 10 us each.
double roughnessOf(const Eigen::Matrix3Xd& points,
                   const Eigen::Matrix3Xd& normals,
                   const geometry::KdTree& tree);

}  // namespace handgraft::cloud
