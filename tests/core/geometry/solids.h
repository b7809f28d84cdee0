#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::test {

/// A ring about z, its tube's vertices on the torus; faces look outwards.
inline geometry::TriangleMesh makeTorus(double ring_m, double tube_m, int around, int along) {
  Eigen::Matrix3Xd vertices(3, around * along);
  Eigen::Matrix3Xi faces(3, 2 * around * along);
  const auto index = [&](int i, int j) {
    return (i % around) * along + j % along;
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < along; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around;
      const double v = 2.0 * std::numbers::pi * j / along;
      const double reach = ring_m + tube_m * std::cos(v);
      vertices.col(index(i, j)) << reach * std::cos(u), reach * std::sin(u),
          tube_m * std::sin(v);
      faces.col(2 * index(i, j)) << index(i, j), index(i + 1, j), index(i + 1, j + 1);
      faces.col(2 * index(i, j) + 1) << index(i, j), index(i + 1, j + 1), index(i, j + 1);
    }
  }
  return {vertices, faces};
}

/// Evenly in the cube of `half` to either side of the origin.
inline Eigen::Vector3d randomIn(double half, std::mt19937& random) {
  std::uniform_real_distribution<double> side(-half, half);
  const double x = side(random);
  const double y = side(random);
  return {x, y, side(random)};
}

}  // namespace handgraft::test
