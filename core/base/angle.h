#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace handgraft {

constexpr double inDegrees(double rad) {
  return rad * 180.0 / std::numbers::pi;
}

/// In [0, pi] rad, also where the cosine is rounded; 0 where one of them has no length.
inline double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace handgraft
