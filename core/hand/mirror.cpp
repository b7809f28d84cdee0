#include "core/hand/mirror.h"

#include <utility>
#include <vector>

namespace handgraft::hand {

namespace {

const Eigen::Vector3d mirror_x(-1.0, 1.0, 1.0);

std::vector<Shape> mirroredShapes(std::vector<Shape> shapes) {
  const Eigen::Affine3d S(Eigen::Scaling(mirror_x));
  for (Shape& shape : shapes)
    shape.mesh_L = geometry::transformed(shape.mesh_L, S);  // turns the faces over as well
  return shapes;
}

}  // namespace

HandModel mirrored(const HandModel& model, std::string name) {
  std::vector<Link> links;
  for (const Link& link : model.links())
    links.push_back({link.name, mirroredShapes(link.visuals), mirroredShapes(link.collisions)});
  std::vector<Joint> joints = model.joints();
  for (Joint& joint : joints) {
    const Eigen::DiagonalMatrix<double, 3> S(mirror_x);
    joint.X_PJ.linear() = S * joint.X_PJ.linear() * S;
    joint.X_PJ.translation() = S * joint.X_PJ.translation();
    // A turn about an axis, seen in the mirror, is the opposite turn about the reflected axis.
    joint.axis_J = S * joint.axis_J * (joint.type == JointType::kRevolute ? -1.0 : 1.0);
  }
  return HandModel(std::move(name), std::move(links), std::move(joints))
      .withRestPose(model.restPose())
      .asMirror(!model.isMirror());
}

}  // namespace handgraft::hand
