#include "core/placement/open_directions.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/tangent.h"

namespace handgraft::placement {
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

std::optional<Eigen::Vector3d> skinDirectionShownBy(const hand::Skin& skin,
                                                    const hand::LinkPoses& X_SW,
                                                    const geometry::SurfacePoint& root_S,
                                                    const Eigen::Vector3d& bone_S,
                                                    const Eigen::Vector3d& d_W,
                                                    double most_rad) {
  const int link = skin.faceLinks()[static_cast<std::size_t>(root_S.face)];
  if (link < 0) return std::nullopt;
  const Eigen::Vector3d d_S = X_SW[static_cast<std::size_t>(link)].linear() * d_W;
  const auto shown_S = geometry::tangentAt(skin.mesh(), root_S, d_S);
  if (!shown_S) return std::nullopt;
  const Eigen::Vector3d n_S = normalOf(skin.mesh(), root_S);
  const double turn = std::atan2(n_S.dot(bone_S.cross(*shown_S)), bone_S.dot(*shown_S));
  return geometry::tangentTurned(skin.mesh(), root_S, bone_S,
                                 std::clamp(turn, -most_rad, most_rad));
}

}  // namespace handgraft::placement
