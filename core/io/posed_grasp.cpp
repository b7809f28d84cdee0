#include "core/io/posed_grasp.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

constexpr std::array<float, 3> kHandColor{0.35F, 0.45F, 0.60F};
constexpr std::array<float, 3> kObjectColor{0.75F, 0.55F, 0.30F};

}  // namespace

std::vector<JointValue> jointValues(const hand::HandModel& model, const Eigen::VectorXd& q) {
  HANDGRAFT_REQUIRE(q.size() == model.dofCount());
  std::vector<JointValue> values;
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    const hand::Joint& joint = model.dofJoint(dof);
    values.push_back({joint.name, q[dof], joint.type == hand::JointType::kPrismatic, false});
  }
  for (const hand::Joint& joint : model.joints()) {
    if (!joint.mimic) continue;
    const auto& nodes = model.nodes();
    const auto node = std::find_if(nodes.begin(), nodes.end(), [&](const auto& one) {
      return one.joint_name == joint.name;
    });
    if (node == nodes.end() || node->dof < 0) continue;
    values.push_back({joint.name, node->multiplier * q[node->dof] + node->offset,
                      joint.type == hand::JointType::kPrismatic, true});
  }
  return values;
}

std::vector<ScenePart> partsOf(const PosedGrasp& grasp) {
  HANDGRAFT_REQUIRE(grasp.model && grasp.object_O);
  const hand::LinkPoses X_WL = hand::forwardKinematics(*grasp.model, grasp.pose);
  std::vector<ScenePart> parts;
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    const hand::Link& link = grasp.model->links()[i];
    std::vector<geometry::TriangleMesh> solids;
    for (const hand::Shape& shape : link.surface())
      solids.push_back(shape.mesh_L);
    if (solids.empty()) continue;
    parts.push_back({link.name, kHandColor, geometry::merged(solids), X_WL[i]});
  }
  parts.push_back({"object " + grasp.object, kObjectColor, *grasp.object_O, grasp.X_WO});
  return parts;
}

std::vector<Pose> partPoses(const PosedGrasp& grasp) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(*grasp.model, grasp.pose);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < X_WL.size(); ++i)
    if (!grasp.model->links()[i].surface().empty()) poses.push_back(X_WL[i]);
  poses.push_back(grasp.X_WO);
  return poses;
}

}  // namespace handgraft::io
