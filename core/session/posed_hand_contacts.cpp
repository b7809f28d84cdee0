#include "core/session/posed_hand_contacts.h"

#include <utility>
#include <vector>

namespace handgraft::session {

std::vector<contact::PosedSurface> posedSurfaces(const hand::HandModel& model,
                                                 const hand::HandPose& pose,
                                                 const Pose& X_WO) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, pose);
  const Pose X_OW = X_WO.inverse();
  std::vector<contact::PosedSurface> parts;
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    const hand::Link& link = model.links()[i];
    if (link.surface().empty()) continue;
    const Eigen::Affine3d X_OL(Eigen::Isometry3d(X_OW * X_WL[i]));
    std::vector<geometry::TriangleMesh> shapes_O;
    for (const hand::Shape& shape : link.surface())
      shapes_O.push_back(geometry::transformed(shape.mesh_L, X_OL));
    parts.push_back({link.name, geometry::merged(shapes_O)});
  }
  return parts;
}

}  // namespace handgraft::session
