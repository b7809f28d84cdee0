#include "core/session/open_directions.h"

#include "core/geometry/tangent.h"

namespace handgraft::session {
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
