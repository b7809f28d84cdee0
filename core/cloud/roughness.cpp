#include "core/cloud/roughness.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/QR>

namespace handgraft::cloud {

double roughnessOf(const Eigen::Matrix3Xd& points,
                   const Eigen::Matrix3Xd& normals,
                   const geometry::KdTree& tree) {
  constexpr int kNeighbours = 18;
  constexpr Eigen::Index kMostJudged = 4000;
  std::vector<double> off;
  const Eigen::Index step = 1 + points.cols() / kMostJudged;
  for (Eigen::Index i = 0; i < points.cols(); i += step) {
    const Eigen::Vector3d n = normals.col(i);
    const Eigen::Vector3d t = n.unitOrthogonal();
    const Eigen::Vector3d b = n.cross(t);
    const auto near = tree.nearestFew(points.col(i), kNeighbours + 1);
    const double reach = near.back().distance;
    if (!(reach > 0.0)) continue;
    Eigen::Matrix<double, kNeighbours, 6> terms;
    Eigen::Matrix<double, kNeighbours, 1> height;
    int row = 0;
    for (const auto& hit : near) {
      if (hit.index == i || row == kNeighbours) continue;
      const Eigen::Vector3d arm = (points.col(hit.index) - points.col(i)) / reach;
      const double x = arm.dot(t);
      const double y = arm.dot(b);
      terms.row(row) << 1.0, x, y, x * x, x * y, y * y;
      height[row++] = arm.dot(n);
    }
    if (row < kNeighbours) continue;
    off.push_back(reach * std::abs(terms.colPivHouseholderQr().solve(height)[0]));
  }
  if (off.empty()) return 0.0;
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle;
}

}  // namespace handgraft::cloud
