#include "core/contact/patch.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/error.h"

namespace handgraft::contact {
namespace {

using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kParallelTolerance = 1e-6;  // sine of the angle between direction and normal

/// The halfedge from `a` to `b`, or from `b` to `a` where the surface ends or is not oriented;
/// -1 if no face has both.
int halfedgeBetween(const TriangleMesh& mesh, int a, int b) {
  for (const int* h = mesh.outgoingBegin(a); h != mesh.outgoingEnd(a); ++h) {
    if (mesh.to(*h) == b) return *h;
  }
  for (const int* h = mesh.outgoingBegin(b); h != mesh.outgoingEnd(b); ++h) {
    if (mesh.to(*h) == a) return *h;
  }
  return -1;
}

/// The place on halfedge `h` at share `t` of the way from vertex `from`.
SurfacePoint pointOnEdge(const TriangleMesh& mesh, int h, int from, double t) {
  SurfacePoint point;
  point.face = TriangleMesh::faceOf(h);
  const double along = mesh.from(h) == from ? t : 1.0 - t;
  point.barycentric[h % 3] = 1.0 - along;
  point.barycentric[TriangleMesh::next(h) % 3] = along;
  return point;
}

void requireVertex(const TriangleMesh& mesh, int v) {
  if (v < 0 || v >= mesh.vertexCount()) {
    rejectInput("boundary vertex {} does not exist; permitted are 0 to {}", v,
                mesh.vertexCount() - 1);
  }
}

/// One halfedge for each pair of neighbours.
std::vector<int> halfedgesOf(const TriangleMesh& mesh, const std::vector<int>& loop) {
  if (loop.size() < 3) {
    rejectInput("boundary of {} vertices; at least 3 are needed", loop.size());
  }
  for (const int v : loop)
    requireVertex(mesh, v);
  std::vector<int> halfedges(loop.size());
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int a = loop[i];
    const int b = loop[(i + 1) % loop.size()];
    halfedges[i] = halfedgeBetween(mesh, a, b);
    if (a == b || halfedges[i] < 0) {
      rejectInput("boundary vertices {} and {} are neighbours in the loop, but share no edge",
                  a, b);
    }
  }
  return halfedges;
}

void validateBoundary(const TriangleMesh& mesh, const std::vector<int>& boundary) {
  halfedgesOf(mesh, boundary);
  std::unordered_set<int> seen;
  for (const int v : boundary) {
    if (!seen.insert(v).second) {
      rejectInput("boundary passes vertex {} twice; the loop must be simple", v);
    }
  }
}

void validateDirection(const TriangleMesh& mesh, const Patch& patch) {
  const Eigen::Vector3d& d = *patch.direction_O;
  if (!d.allFinite() || !(d.norm() > 1e-12)) {
    rejectInput("direction ({}, {}, {}) is no finite vector other than zero", d.x(), d.y(),
                d.z());
  }
  const Eigen::Vector3d n = geometry::normalOf(mesh, patch.root);
  if (d.normalized().cross(n).norm() < kParallelTolerance) {
    rejectInput("direction ({}, {}, {}) is parallel to the surface's normal at the root", d.x(),
                d.y(), d.z());
  }
}

void validateUnnamed(const TriangleMesh& mesh, const Patch& patch) {
  geometry::validate(mesh, patch.root, "root");
  if (patch.direction_O) validateDirection(mesh, patch);
  if (!patch.boundary.empty()) validateBoundary(mesh, patch.boundary);
  if (patch.interpolation_boundary.size() < 3) {
    rejectInput("interpolation boundary of {} points; at least 3 are needed",
                patch.interpolation_boundary.size());
  }
  for (const SurfacePoint& point : patch.interpolation_boundary) {
    geometry::validate(mesh, point, "interpolation boundary point");
  }
  if (!(patch.weight >= 0.0 && patch.weight <= kLargestWeight)) {
    rejectInput("weight is {}; permitted are 0 to {}", patch.weight, kLargestWeight);
  }
}

}  // namespace

std::vector<SurfacePoint> sampleLoop(const TriangleMesh& mesh,
                                     const std::vector<int>& loop,
                                     int count) {
  if (count < kFewestInterpolationPoints || count > kMostInterpolationPoints) {
    rejectInput("interpolation count is {}; permitted are {} to {}", count,
                kFewestInterpolationPoints, kMostInterpolationPoints);
  }
  const std::vector<int> halfedges = halfedgesOf(mesh, loop);
  std::vector<double> arc(loop.size() + 1, 0.0);  // arc[i]: length from the start to loop[i]
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int h = halfedges[i];
    arc[i + 1] = arc[i] + (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).norm();
  }
  if (!(arc.back() > 0.0)) rejectInput("boundary has no length");

  std::vector<SurfacePoint> points;
  points.reserve(static_cast<std::size_t>(count));
  std::size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double s = arc.back() * k / count;
    while (i + 1 < loop.size() && arc[i + 1] <= s)
      ++i;
    const double length = arc[i + 1] - arc[i];
    const double t = length > 0.0 ? std::clamp((s - arc[i]) / length, 0.0, 1.0) : 0.0;
    points.push_back(pointOnEdge(mesh, halfedges[i], loop[i], t));
  }
  return points;
}

void validate(const TriangleMesh& mesh, const Patch& patch) {
  if (patch.name.empty()) rejectInput("a patch has no name");
  try {
    validateUnnamed(mesh, patch);
  } catch (const InvalidInput& error) {
    rejectInput("patch {}: {}", quoted(patch.name), error.what());
  }
}

}  // namespace handgraft::contact
