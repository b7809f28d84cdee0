#pragma once

#include <vector>

#include <Eigen/Core>

namespace handgraft::geometry {

/// Thins points out so that none is nearer than `spacing` to another one of its group; the
/// first ones stay. Every point left out has one of its group within `spacing`.
struct Thinned {
  std::vector<int> kept;     ///< rising
  std::vector<int> nearest;  ///< per point, which entry of `kept`, of its group, is nearest
};

/// Shapes: points 3 x N, groups N. Errors: BrokenContract unless spacing > 0. Cost: O(N).
Thinned thinOut(const Eigen::Matrix3Xd& points, const std::vector<int>& groups, double spacing);

}  // namespace handgraft::geometry
