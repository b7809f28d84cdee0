#include "core/geometry/tangent.h"

#include <Eigen/Geometry>

#include "core/base/pose.h"

namespace handgraft::geometry {
namespace {

constexpr double kParallelTolerance = 1e-3;  // sine; below it the direction says nothing

}  // namespace

std::optional<Eigen::Vector3d> tangentAt(const TriangleMesh& mesh,
                                         const SurfacePoint& point,
                                         const Eigen::Vector3d& direction) {
  const Eigen::Vector3d n = normalOf(mesh, point);
  const Eigen::Vector3d along = direction.normalized();
  const Eigen::Vector3d tangent = along - along.dot(n) * n;
  if (!(tangent.norm() > kParallelTolerance)) return std::nullopt;
  return tangent.normalized();
}

Eigen::Vector3d anyTangentAt(const TriangleMesh& mesh, const SurfacePoint& point) {
  return normalOf(mesh, point).unitOrthogonal();
}

Eigen::Vector3d tangentCarried(const TriangleMesh& mesh,
                               const SurfacePoint& from,
                               const SurfacePoint& to,
                               const Eigen::Vector3d& direction) {
  const auto turn =
      Eigen::Quaterniond::FromTwoVectors(normalOf(mesh, from), normalOf(mesh, to));
  const Eigen::Vector3d tangent =
      tangentAt(mesh, from, direction).value_or(anyTangentAt(mesh, from));
  return tangentAt(mesh, to, turn * tangent).value_or(anyTangentAt(mesh, to));
}

Eigen::Vector3d tangentTurned(const TriangleMesh& mesh,
                              const SurfacePoint& point,
                              const Eigen::Vector3d& direction,
                              double angle_rad) {
  return rotationFromVector(angle_rad * normalOf(mesh, point)) * direction;
}

}  // namespace handgraft::geometry
