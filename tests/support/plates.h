#pragma once

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::test {

/// A flat grid of `columns` x `rows` squares of `step` metres, each cut in two, centred at the
/// origin of the xy plane, looking to +z. Vertex (i, j) is number j * (columns + 1) + i.
inline geometry::TriangleMesh makePlate(int columns, int rows, double step) {
  Eigen::Matrix3Xd vertices(3, (columns + 1) * (rows + 1));
  Eigen::Matrix3Xi faces(3, 2 * columns * rows);
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      vertices.col(j * (columns + 1) + i) << (i - 0.5 * columns) * step,
          (j - 0.5 * rows) * step, 0.0;
    }
  }
  int f = 0;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i;
      const int d = a + columns + 1;
      faces.col(f++) << a, a + 1, d + 1;
      faces.col(f++) << a, d + 1, d;
    }
  }
  return {vertices, faces};
}

}  // namespace handgraft::test
