#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::test {

/// A triangulated rectangle, rolled or bent by a map; its flat places are the unrolled truth.
struct Sheet {
  geometry::TriangleMesh mesh;
  std::vector<Eigen::Vector2d> flat;
};

/// `columns` x `rows` cells of [0, width] x [0, height], vertices shaken by `jitter` cells
/// inside (below 0.25, so that cells stay convex), diagonals at random. `wrap` joins the right
/// side to the left one. Deterministic.
inline Sheet makeSheet(int columns,
                       int rows,
                       double width,
                       double height,
                       double jitter,
                       bool wrap,
                       const std::function<Eigen::Vector3d(const Eigen::Vector2d&)>& bend) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-jitter, jitter);
  const int per_row = wrap ? columns : columns + 1;
  Sheet sheet;
  Eigen::Matrix3Xd vertices(3, per_row * (rows + 1));
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column < per_row; ++column) {
      Eigen::Vector2d cell(column, row);
      const bool inside = row > 0 && row < rows && (wrap || (column > 0 && column < columns));
      if (inside) cell += Eigen::Vector2d(wrap ? 0.0 : shake(random), shake(random));
      sheet.flat.emplace_back(cell.x() * width / columns, cell.y() * height / rows);
      vertices.col(row * per_row + column) = bend(sheet.flat.back());
    }
  }
  std::vector<int> corners;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int a = row * per_row + column;
      const int b = row * per_row + (column + 1) % per_row;
      const int c = b + per_row;
      const int d = a + per_row;
      if (random() & 1U) {
        corners.insert(corners.end(), {a, b, c, a, c, d});
      } else {
        corners.insert(corners.end(), {a, b, d, b, c, d});
      }
    }
  }
  sheet.mesh = geometry::TriangleMesh(
      std::move(vertices),
      Eigen::Map<Eigen::Matrix3Xi>(corners.data(), 3, static_cast<int>(corners.size()) / 3));
  return sheet;
}

inline Sheet makePlane(double jitter = 0.2, double height = 1.0) {
  return makeSheet(30, 30, 1.0, height, jitter, false, [](const Eigen::Vector2d& p) {
    return Eigen::Vector3d(p.x(), p.y(), 0.0);
  });
}

/// A prism of unit radius whose every side is a column of the sheet, rolled up.
struct Tube {
  int sides;
  double width;  ///< of the polyhedron, unrolled
  Sheet sheet;
};

inline Tube makeTube(int sides, int rows, double height, double jitter) {
  constexpr double kPi = std::numbers::pi;
  const double width = 2.0 * sides * std::sin(kPi / sides);
  return {sides, width,
          makeSheet(sides, rows, width, height, jitter, true, [&](const Eigen::Vector2d& p) {
            const double angle = 2.0 * kPi * p.x() / width;
            return Eigen::Vector3d(std::cos(angle), std::sin(angle), p.y());
          })};
}

}  // namespace handgraft::test
