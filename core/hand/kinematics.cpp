#include "core/hand/kinematics.h"

#include "core/base/error.h"

namespace handgraft::hand {

void forwardKinematics(const HandModel& model,
                       const Pose& X_AH,
                       const Eigen::VectorXd& q,
                       LinkPoses& X_AL) {
  HANDGRAFT_REQUIRE(q.size() == model.dofCount());
  X_AL.resize(static_cast<std::size_t>(model.linkCount()));
  X_AL[0] = X_AH;
  for (const HandModel::Node& node : model.nodes()) {
    const Pose& X_AP = X_AL[static_cast<std::size_t>(node.parent_link)];
    Pose& X_AC = X_AL[static_cast<std::size_t>(node.link)];
    X_AC.linear().noalias() = X_AP.linear() * node.X_PJ.linear();
    X_AC.translation().noalias() = X_AP.linear() * node.X_PJ.translation();
    X_AC.translation() += X_AP.translation();
    X_AC.makeAffine();
    if (node.type == JointType::kFixed) continue;

    const double value = node.multiplier * q[node.dof] + node.offset;
    if (node.type == JointType::kRevolute) {
      const Eigen::Matrix3d R_AJ = X_AC.linear();
      X_AC.linear().noalias() = R_AJ * Eigen::AngleAxisd(value, node.axis_J).toRotationMatrix();
    } else {
      X_AC.translation() += X_AC.linear() * (value * node.axis_J);
    }
  }
}

std::vector<std::vector<int>> dofsMoving(const HandModel& model) {
  std::vector<std::vector<int>> dofs(static_cast<std::size_t>(model.linkCount()));
  for (const HandModel::Node& node : model.nodes()) {
    std::vector<int>& own = dofs[static_cast<std::size_t>(node.link)];
    own = dofs[static_cast<std::size_t>(node.parent_link)];
    if (node.dof >= 0) own.push_back(node.dof);
  }
  return dofs;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> pointJacobian(const HandModel& model,
                                                       const LinkPoses& X_AL,
                                                       int link,
                                                       const Eigen::Vector3d& p_A) {
  HANDGRAFT_REQUIRE(X_AL.size() == static_cast<std::size_t>(model.linkCount()));
  HANDGRAFT_REQUIRE(link >= 0 && link < model.linkCount());
  Eigen::Matrix<double, 6, Eigen::Dynamic> J =
      Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, model.dofCount());
  // Every joint between the link and the root moves the point; joints that share a dof add up.
  while (link != 0) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(link - 1)];
    if (node.type != JointType::kFixed) {
      // The axis is the same in J and in the child: a joint does not turn its own axis.
      const Pose& X_AC = X_AL[static_cast<std::size_t>(link)];
      const Eigen::Vector3d axis_A = node.multiplier * (X_AC.linear() * node.axis_J);
      if (node.type == JointType::kRevolute) {
        J.col(node.dof).head<3>() += axis_A;
        J.col(node.dof).tail<3>() += axis_A.cross(p_A - X_AC.translation());
      } else {
        J.col(node.dof).tail<3>() += axis_A;
      }
    }
    link = node.parent_link;
  }
  return J;
}

}  // namespace handgraft::hand
