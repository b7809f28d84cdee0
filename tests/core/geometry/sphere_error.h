#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/log_map.h"
#include "core/geometry/surface_point.h"

namespace handgraft::test {

/// Mean errors of a log map against arcs on the sphere.
struct SphereError {
  double r = 0.0;    ///< relative
  double phi = 0.0;  ///< rad, after removing one constant rotation a source
};

/// `count` places of the unit icosphere with 10,242 vertices, at random, each at these weights
/// of its face. Deterministic.
inline std::vector<geometry::SurfacePoint> sourcesOnASphere(const Eigen::Vector3d& barycentric,
                                                            int count) {
  std::mt19937 random(3);
  std::vector<geometry::SurfacePoint> sources;
  for (int i = 0; i < count; ++i)
    sources.push_back({static_cast<int>(random() % 20480), barycentric});
  return sources;
}

/// Three sources at vertices and three inside faces.
inline std::vector<geometry::SurfacePoint> mixedSourcesOnASphere() {
  std::vector<geometry::SurfacePoint> sources = sourcesOnASphere({0.0, 0.0, 1.0}, 3);
  for (const geometry::SurfacePoint& inside : sourcesOnASphere({0.2, 0.5, 0.3}, 3))
    sources.push_back(inside);
  return sources;
}

/// Of the unit icosphere with 10,242 vertices, inside 0.2 pi of each source.
inline SphereError errorOnASphere(
    const std::vector<geometry::SurfacePoint>& sources,
    const std::function<geometry::LogMap(const geometry::TriangleMesh&,
                                         const geometry::SurfacePoint&,
                                         const Eigen::Vector3d&,
                                         double radius)>& compute) {
  const geometry::TriangleMesh sphere = geometry::makeSphere(1.0, 5);
  const Eigen::Vector3d direction(0.3, 0.8, 0.4);
  SphereError error;
  int count = 0;
  for (const geometry::SurfacePoint& source : sources) {
    const geometry::LogMap map = compute(sphere, source, direction, 0.2 * std::numbers::pi);
    const Eigen::Vector3d z = positionOf(sphere, source).normalized();
    const Eigen::Vector3d x = (direction - direction.dot(z) * z).normalized();
    const Eigen::Vector3d y = z.cross(x);
    std::vector<double> differences;
    for (const int v : map.vertices) {
      const Eigen::Vector3d p = sphere.vertex(v);
      const double r = std::atan2(z.cross(p).norm(), z.dot(p));
      if (r < 1e-6) continue;
      error.r += std::abs(map.r[v] - r) / r;
      differences.push_back(
          std::remainder(map.phi[v] - std::atan2(y.dot(p), x.dot(p)), 2.0 * std::numbers::pi));
    }
    const double mean = std::accumulate(differences.begin(), differences.end(), 0.0) /
                        static_cast<double>(differences.size());
    for (const double d : differences)
      error.phi += std::abs(d - mean);
    count += static_cast<int>(differences.size());
  }
  error.r /= count;
  error.phi /= count;
  return error;
}

}  // namespace handgraft::test
