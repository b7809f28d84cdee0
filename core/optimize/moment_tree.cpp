#include "core/optimize/moment_tree.h"

#include <cmath>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

using hand::HandModel;
using hand::JointType;

TreeJoint jointOf(const HandModel::Node& node, int parent_body, const Pose& X_PJ) {
  TreeJoint joint;
  joint.parent_body = parent_body;
  joint.type = node.type;
  joint.dof = node.dof;
  joint.multiplier = node.multiplier;
  joint.offset = node.offset;
  joint.axis_P = X_PJ.linear() * node.axis_J;
  joint.p_PB = X_PJ.translation();
  if (node.type == JointType::kRevolute) {
    // Rodrigues: R = a a^T + sin K + cos (I - a a^T).
    const Eigen::Matrix3d along = node.axis_J * node.axis_J.transpose();
    joint.still = X_PJ.linear() * along;
    joint.sine = X_PJ.linear() * crossMatrix(node.axis_J);
    joint.cosine = X_PJ.linear() * (Eigen::Matrix3d::Identity() - along);
  } else {
    joint.still = X_PJ.linear();
  }
  return joint;
}

/// Lays all links that are needed into bodies, depth first; the root is laid already.
std::vector<TreeJoint> layLinks(const HandModel& model,
                                const std::vector<std::vector<int>>& children,
                                const std::vector<bool>& needed,
                                std::vector<LinkPlace>& places) {
  std::vector<TreeJoint> joints;
  std::vector<int> waiting(children[0].rbegin(), children[0].rend());
  while (!waiting.empty()) {
    const auto link = static_cast<std::size_t>(waiting.back());
    waiting.pop_back();
    if (!needed[link]) continue;
    const HandModel::Node& node = model.nodes()[link - 1];
    const auto parent = static_cast<std::size_t>(node.parent_link);
    const Pose X_BJ = places[parent].X_BL * node.X_PJ;
    if (node.type == JointType::kFixed) {
      places[link] = {places[parent].body, X_BJ};
    } else {
      joints.push_back(jointOf(node, places[parent].body, X_BJ));
      places[link].body = static_cast<int>(joints.size());
    }
    waiting.insert(waiting.end(), children[link].rbegin(), children[link].rend());
  }
  return joints;
}

}  // namespace

void placeBodies(const MomentTree& tree,
                 const Eigen::Matrix3d& R_WH,
                 const Eigen::VectorXd& q,
                 std::vector<BodyPlace>& places) {
  places[0].R_WB = R_WH;
  for (std::size_t k = 0; k < tree.joints.size(); ++k) {
    const TreeJoint& joint = tree.joints[k];
    const BodyPlace& parent = places[static_cast<std::size_t>(joint.parent_body)];
    BodyPlace& body = places[k + 1];
    const double value = joint.multiplier * q[joint.dof] + joint.offset;
    body.axis_W.noalias() = parent.R_WB.lazyProduct(joint.axis_P);
    body.p_HB_W = parent.p_HB_W;
    body.p_HB_W.noalias() += parent.R_WB.lazyProduct(joint.p_PB);
    if (joint.type == JointType::kRevolute) {
      const Eigen::Matrix3d R_PB =
          joint.still + std::sin(value) * joint.sine + std::cos(value) * joint.cosine;
      body.R_WB.noalias() = parent.R_WB.lazyProduct(R_PB);
    } else {
      body.R_WB.noalias() = parent.R_WB.lazyProduct(joint.still);
      body.p_HB_W += value * body.axis_W;
    }
  }
}

MomentTree makeMomentTree(const PoseProblem& problem) {
  const HandModel& model = *problem.model;
  const auto link_count = static_cast<std::size_t>(model.linkCount());

  // === Links that carry pairs or samples, and those on the way there
  std::vector<bool> needed(link_count, false);
  for (const PointPair& pair : problem.pairs) {
    HANDGRAFT_REQUIRE(pair.link >= 0 && pair.link < model.linkCount());
    if (pair.weight > 0.0) needed[static_cast<std::size_t>(pair.link)] = true;
  }
  if (problem.avoidance != nullptr) {
    for (const hand::LinkSolid& solid : problem.avoidance->hand->links())
      needed[static_cast<std::size_t>(solid.link)] = true;
  }
  std::vector<std::vector<int>> children(link_count);
  for (const HandModel::Node& node : model.nodes())
    children[static_cast<std::size_t>(node.parent_link)].push_back(node.link);
  for (auto node = model.nodes().rbegin(); node != model.nodes().rend(); ++node) {
    if (needed[static_cast<std::size_t>(node->link)]) {
      needed[static_cast<std::size_t>(node->parent_link)] = true;
    }
  }

  MomentTree tree;
  std::vector<LinkPlace>& places = tree.links;
  places.resize(link_count);
  places[0].body = 0;
  tree.joints = layLinks(model, children, needed, places);

  // === Moments: centroids first, then the rest about them
  std::vector<BodyMoments> by_body(static_cast<std::size_t>(tree.bodyCount()));
  const auto moments_of = [&](const PointPair& pair) -> BodyMoments& {
    const int body = places[static_cast<std::size_t>(pair.link)].body;
    return by_body[static_cast<std::size_t>(body)];
  };
  for (const PointPair& pair : problem.pairs) {
    if (!(pair.weight > 0.0)) continue;
    BodyMoments& m = moments_of(pair);
    m.weight += pair.weight;
    m.p_B += pair.weight * (places[static_cast<std::size_t>(pair.link)].X_BL * pair.p_L);
    m.x_W += pair.weight * pair.p_W;
  }
  for (std::size_t body = 0; body < by_body.size(); ++body) {
    BodyMoments& m = by_body[body];
    m.body = static_cast<int>(body);
    if (m.weight <= 0.0) continue;
    m.p_B /= m.weight;
    m.x_W /= m.weight;
  }
  for (const PointPair& pair : problem.pairs) {
    if (!(pair.weight > 0.0)) continue;
    addAboutCentroids(pair, places[static_cast<std::size_t>(pair.link)].X_BL, moments_of(pair));
  }
  for (BodyMoments& m : by_body) {
    if (m.weight > 0.0) tree.moments.push_back(m);
  }
  return tree;
}

}  // namespace handgraft::optimize
