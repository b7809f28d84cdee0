#include "client/link/surface_pick.h"

#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

Eigen::Vector3d vertex(const v1::Mesh& mesh, std::size_t index) {
  if (index >= mesh.vertices_m().size() / 3) {
    throw TransportError(fmt::format("the server sent a mesh whose face has vertex {} of {}",
                                     index, mesh.vertices_m().size() / 3));
  }
  const float* xyz = mesh.vertices_m().data() + 3 * index;
  return {xyz[0], xyz[1], xyz[2]};
}

std::array<Eigen::Vector3d, 3> corners(const v1::Mesh& mesh, std::size_t face) {
  return {vertex(mesh, mesh.triangles()[3 * face]),
          vertex(mesh, mesh.triangles()[3 * face + 1]),
          vertex(mesh, mesh.triangles()[3 * face + 2])};
}

void requireFaces(const v1::Mesh& mesh) {
  if (mesh.triangles().size() < 3) rejectInput("the surface has no faces");
}

// Barycentric weights of the point of the segment a-b nearest to p.
Eigen::Vector2d onSegment(const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b,
                          const Eigen::Vector3d& p) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return {1.0 - t, t};
}

// Of the nearest point of a triangle: the foot of the perpendicular where it lies inside, else
// the best place on the three edges.
Eigen::Vector3d onTriangle(const std::array<Eigen::Vector3d, 3>& corner,
                           const Eigen::Vector3d& p) {
  const Eigen::Vector3d u = corner[1] - corner[0];
  const Eigen::Vector3d v = corner[2] - corner[0];
  const Eigen::Vector3d n = u.cross(v);
  const double area2 = n.squaredNorm();
  if (area2 > 0.0) {
    const Eigen::Vector3d w = p - corner[0];
    const double b2 = u.cross(w).dot(n) / area2;
    const double b1 = w.cross(v).dot(n) / area2;
    if (b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0) return {1.0 - b1 - b2, b1, b2};
  }
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Eigen::Vector2d weights = onSegment(corner[i], corner[j], p);
    const double distance2 =
        (weights[0] * corner[i] + weights[1] * corner[j] - p).squaredNorm();
    if (distance2 >= least) continue;
    least = distance2;
    best.setZero();
    best[i] = weights[0];
    best[j] = weights[1];
  }
  return best;
}

}  // namespace

v1::SurfacePoint nearestPoint(const v1::Mesh& mesh, const Eigen::Vector3d& p) {
  requireFaces(mesh);
  v1::SurfacePoint nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t face = 0; face < mesh.triangles().size() / 3; ++face) {
    const auto corner = corners(mesh, face);
    const Eigen::Vector3d b = onTriangle(corner, p);
    const double distance2 =
        (b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2] - p).squaredNorm();
    if (!(distance2 < least)) continue;
    least = distance2;
    nearest.face(static_cast<std::int32_t>(face));
    nearest.barycentric() = {b[0], b[1], b[2]};
  }
  return nearest;
}

Eigen::Vector3d positionOf(const v1::Mesh& mesh, const v1::SurfacePoint& point) {
  const auto face = static_cast<std::size_t>(point.face());
  if (point.face() < 0 || face >= mesh.triangles().size() / 3) {
    throw TransportError(fmt::format("the server named face {} of a mesh with {}", point.face(),
                                     mesh.triangles().size() / 3));
  }
  const auto corner = corners(mesh, face);
  const auto& b = point.barycentric();
  return b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2];
}

Eigen::Vector3d furthestVertex(const v1::Mesh& mesh, const Eigen::Vector3d& direction) {
  if (mesh.vertices_m().size() < 3) rejectInput("the surface has no vertices");
  Eigen::Vector3d furthest = vertex(mesh, 0);
  for (std::size_t i = 1; i < mesh.vertices_m().size() / 3; ++i) {
    const Eigen::Vector3d p = vertex(mesh, i);
    if (p.dot(direction) > furthest.dot(direction)) furthest = p;
  }
  return furthest;
}

}  // namespace handgraft::client
