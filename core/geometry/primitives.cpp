#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

namespace {

void requireLength(const char* what, double value_m) {
  if (!std::isfinite(value_m) || value_m <= 0.0) {
    rejectInput("{} is {} m, it must be positive and finite", what, value_m);
  }
}

void requireCount(const char* what, int value, int least, int most) {
  if (value < least || value > most) {
    rejectInput("{} is {}, permitted are {} to {}", what, value, least, most);
  }
}

TriangleMesh meshOf(const std::vector<Eigen::Vector3d>& points,
                    const std::vector<Eigen::Vector3i>& triangles) {
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(points.size()));
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t v = 0; v < points.size(); ++v)
    vertices.col(static_cast<int>(v)) = points[v];
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    faces.col(static_cast<int>(f)) = triangles[f];
  }
  return {std::move(vertices), std::move(faces)};
}

/// Three golden rectangles, on the unit sphere.
std::vector<Eigen::Vector3d> icosahedronCorners() {
  constexpr double kGolden = std::numbers::phi;
  std::vector<Eigen::Vector3d> points;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-kGolden, kGolden}) {
      points.push_back(Eigen::Vector3d(a, b, 0.0).normalized());
      points.push_back(Eigen::Vector3d(0.0, a, b).normalized());
      points.push_back(Eigen::Vector3d(b, 0.0, a).normalized());
    }
  }
  return points;
}

/// The triples of corners at the shortest mutual distance, turned outwards.
std::vector<Eigen::Vector3i> icosahedronFaces(const std::vector<Eigen::Vector3d>& points) {
  constexpr double kGolden = std::numbers::phi;
  const double edge_squared = 4.0 / (1.0 + kGolden * kGolden);
  const auto adjacent = [&](int a, int b) {
    return (points[a] - points[b]).squaredNorm() < 1.1 * edge_squared;
  };
  std::vector<Eigen::Vector3i> triangles;
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      for (int c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(c, a)) continue;
        const bool outward = points[a].dot(points[b].cross(points[c])) > 0.0;
        triangles.emplace_back(a, outward ? b : c, outward ? c : b);
      }
    }
  }
  return triangles;
}

/// Each face becomes four, the new vertices, behind `points`, pushed out to the unit sphere.
std::vector<Eigen::Vector3i> quartered(const std::vector<Eigen::Vector3i>& triangles,
                                       std::vector<Eigen::Vector3d>& points) {
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [place, fresh] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
    if (fresh) points.push_back((points[a] + points[b]).normalized());
    return place->second;
  };
  std::vector<Eigen::Vector3i> finer;
  finer.reserve(4 * triangles.size());
  for (const Eigen::Vector3i& t : triangles) {
    const int ab = middle(t[0], t[1]);
    const int bc = middle(t[1], t[2]);
    const int ca = middle(t[2], t[0]);
    finer.emplace_back(t[0], ab, ca);
    finer.emplace_back(t[1], bc, ab);
    finer.emplace_back(t[2], ca, bc);
    finer.emplace_back(ab, bc, ca);
  }
  return finer;
}

}  // namespace

TriangleMesh makeBox(const Eigen::Vector3d& size_m) {
  for (int axis = 0; axis < 3; ++axis)
    requireLength("box size", size_m[axis]);
  // Vertex v stands at the signs of its bits: bit 0 is +x, bit 1 is +y, bit 2 is +z.
  Eigen::Matrix3Xd vertices(3, 8);
  for (int v = 0; v < 8; ++v) {
    const Eigen::Vector3d signs(v & 1 ? 1.0 : -1.0, v & 2 ? 1.0 : -1.0, v & 4 ? 1.0 : -1.0);
    vertices.col(v) = signs.cwiseProduct(size_m) / 2.0;
  }
  Eigen::Matrix3Xi faces(3, 12);
  faces << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,       //
      3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return {std::move(vertices), std::move(faces)};
}

TriangleMesh makeCylinder(double radius_m, double length_m, int segments) {
  requireLength("cylinder radius", radius_m);
  requireLength("cylinder length", length_m);
  requireCount("cylinder segments", segments, 3, 4096);

  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3i> triangles;
  for (int s = 0; s < segments; ++s) {
    const double angle = 2.0 * std::numbers::pi * s / segments;
    const double x = radius_m * std::cos(angle);
    const double y = radius_m * std::sin(angle);
    points.emplace_back(x, y, -length_m / 2.0);
    points.emplace_back(x, y, length_m / 2.0);
  }
  const int bottom = 2 * segments;
  const int top = bottom + 1;
  points.emplace_back(0.0, 0.0, -length_m / 2.0);
  points.emplace_back(0.0, 0.0, length_m / 2.0);
  for (int s = 0; s < segments; ++s) {
    const int low = 2 * s;
    const int low_next = 2 * ((s + 1) % segments);
    triangles.emplace_back(low, low_next, low_next + 1);
    triangles.emplace_back(low, low_next + 1, low + 1);
    triangles.emplace_back(bottom, low_next, low);
    triangles.emplace_back(top, low + 1, low_next + 1);
  }
  return meshOf(points, triangles);
}

TriangleMesh makeSphere(double radius_m, int subdivisions) {
  requireLength("sphere radius", radius_m);
  requireCount("sphere subdivisions", subdivisions, 0, 8);

  std::vector<Eigen::Vector3d> points = icosahedronCorners();
  std::vector<Eigen::Vector3i> triangles = icosahedronFaces(points);
  for (int level = 0; level < subdivisions; ++level)
    triangles = quartered(triangles, points);
  for (Eigen::Vector3d& point : points)
    point *= radius_m;
  return meshOf(points, triangles);
}

}  // namespace handgraft::geometry
