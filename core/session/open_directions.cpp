#include "core/session/open_directions.h"

#include <Eigen/Geometry>

namespace handgraft::session {
namespace {

constexpr double kParallelTolerance = 1e-3;  // sine; below it the direction says nothing

}  // namespace

std::optional<Eigen::Vector3d> tangentAt(const geometry::TriangleMesh& mesh,
                                         const geometry::SurfacePoint& point,
                                         const Eigen::Vector3d& direction) {
  const Eigen::Vector3d n = normalOf(mesh, point);
  const Eigen::Vector3d along = direction.normalized();
  const Eigen::Vector3d tangent = along - along.dot(n) * n;
  if (!(tangent.norm() > kParallelTolerance)) return std::nullopt;
  return tangent.normalized();
}

Eigen::Vector3d anyTangentAt(const geometry::TriangleMesh& mesh,
                             const geometry::SurfacePoint& point) {
  return normalOf(mesh, point).unitOrthogonal();
}

Eigen::Vector3d tangentCarried(const geometry::TriangleMesh& mesh,
                               const geometry::SurfacePoint& from,
                               const geometry::SurfacePoint& to,
                               const Eigen::Vector3d& direction) {
  const auto turn =
      Eigen::Quaterniond::FromTwoVectors(normalOf(mesh, from), normalOf(mesh, to));
  const Eigen::Vector3d tangent =
      tangentAt(mesh, from, direction).value_or(anyTangentAt(mesh, from));
  return tangentAt(mesh, to, turn * tangent).value_or(anyTangentAt(mesh, to));
}

Eigen::Vector3d directionShownBy(const hand::HandModel& model,
                                 const hand::HandPose& pose,
                                 const Anchor& anchor,
                                 const geometry::TriangleMesh& object_O,
                                 const geometry::SurfacePoint& root_O,
                                 const Pose& X_WO) {
  const hand::LinkPoses X_WL = forwardKinematics(model, pose);
  const Eigen::Vector3d direction_O =
      X_WO.linear().transpose() * (X_WL[anchor.link].linear() * anchor.direction_L);
  return tangentAt(object_O, root_O, direction_O).value_or(anyTangentAt(object_O, root_O));
}

}  // namespace handgraft::session
