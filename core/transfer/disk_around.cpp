#include "core/transfer/disk_around.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace handgraft::transfer {
namespace {

using geometry::LogMap;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kUnevenness = 1.05;   // a way along a scanned surface against one on its arc
constexpr double kMethodSlack = 1.02;  // r of the inexact methods against the true distance

/// The arc between two places whose normals differ, were it a circle's.
double arcBetween(const TriangleMesh& mesh, const SurfacePoint& a, const SurfacePoint& b) {
  const double chord = (positionOf(mesh, a) - positionOf(mesh, b)).norm();
  const double cosine = std::clamp(normalOf(mesh, a).dot(normalOf(mesh, b)), -1.0, 1.0);
  const double half = 0.5 * std::acos(cosine);
  return half > 0.0 ? chord * half / std::sin(half) : chord;
}

/// Length of the shortest way along edges to the farthest of the targets that have one: no
/// geodesic distance is longer. 0 if none has.
double farthestAlongEdges(const TriangleMesh& mesh,
                          const SurfacePoint& source,
                          const std::vector<SurfacePoint>& targets) {
  std::vector<double> distance(static_cast<std::size_t>(mesh.vertexCount()),
                               std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto offer = [&](int v, double d) {
    if (d < distance[static_cast<std::size_t>(v)]) {
      distance[static_cast<std::size_t>(v)] = d;
      queue.emplace(d, v);
    }
  };
  const Eigen::Vector3d origin = positionOf(mesh, source);
  for (const int v : mesh.face(source.face))
    offer(v, (mesh.vertex(v) - origin).norm());
  // Corners of the targets that still wait; all of the source's component at worst.
  std::vector<int> corners;
  for (const SurfacePoint& target : targets) {
    for (const int v : mesh.face(target.face))
      corners.push_back(v);
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::size_t waiting = corners.size();
  while (!queue.empty() && waiting > 0) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[static_cast<std::size_t>(v)]) continue;
    if (std::binary_search(corners.begin(), corners.end(), v)) --waiting;
    for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
      // Both sides of the face, so that edges on the surface's border are walked both ways.
      for (const int to : {mesh.to(*h), mesh.from(TriangleMesh::previous(*h))})
        offer(to, d + (mesh.vertex(to) - mesh.vertex(v)).norm());
    }
  }
  double farthest = 0.0;
  for (const SurfacePoint& target : targets) {
    const Eigen::Vector3d p = positionOf(mesh, target);
    double nearest = std::numeric_limits<double>::infinity();
    for (const int v : mesh.face(target.face)) {
      nearest = std::min(nearest,
                         distance[static_cast<std::size_t>(v)] + (mesh.vertex(v) - p).norm());
    }
    if (std::isfinite(nearest)) farthest = std::max(farthest, nearest);
  }
  return farthest;
}

}  // namespace

LogMap diskAround(const geometry::LogMapper& maps,
                  const SurfacePoint& source,
                  const Eigen::Vector3d& direction,
                  const std::vector<SurfacePoint>& targets,
                  geometry::LogMapMethod method) {
  const TriangleMesh& mesh = maps.mesh();
  double guess = 0.0;
  for (const SurfacePoint& target : targets)
    guess = std::max(guess, arcBetween(mesh, source, target));
  // Targets that all lie on the source want some disk, too.
  const double radius = guess > 0.0 ? kUnevenness * guess : mesh.meanEdgeLength();
  LogMap map = maps.map(source, direction, radius, method);
  const bool is_complete =
      std::all_of(targets.begin(), targets.end(), [&](const SurfacePoint& target) {
        return logCoordinates(mesh, map, target).allFinite();
      });
  if (is_complete) return map;
  const double bound = kMethodSlack * farthestAlongEdges(mesh, source, targets);
  return bound > radius ? maps.map(source, direction, bound, method) : map;
}

}  // namespace handgraft::transfer
