#include "core/hand/floating_base.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/SVD>

#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

constexpr int kFreedoms = 6;
/// Below this share of the largest singular value two freedoms are one (rad and m alike: the
/// joints of a floating base stand in one point).
constexpr double kRankTolerance = 1e-6;

/// The only child of each link, as a node index; -1 where there is none or there are several.
std::vector<int> onlyChildren(const HandModel& model) {
  std::vector<int> child(static_cast<std::size_t>(model.linkCount()), -1);
  std::vector<int> count(child.size(), 0);
  for (std::size_t i = 0; i < model.nodes().size(); ++i) {
    const auto parent = static_cast<std::size_t>(model.nodes()[i].parent_link);
    child[parent] = ++count[parent] == 1 ? static_cast<int>(i) : -1;
  }
  return child;
}

int freedomsOf(const HandModel& model, int link) {
  LinkPoses X_HL;
  forwardKinematics(model, Pose::Identity(), Eigen::VectorXd::Zero(model.dofCount()), X_HL);
  const auto J =
      pointJacobian(model, X_HL, link, X_HL[static_cast<std::size_t>(link)].translation());
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J);
  svd.setThreshold(kRankTolerance);
  return static_cast<int>(svd.rank());
}

/// Link in which a chain of empty links first has all freedoms, or -1.
int endOfFloatingBase(const HandModel& model, const std::set<std::string>& solid_links) {
  const std::vector<int> only_child = onlyChildren(model);
  int link = 0;
  int movable = 0;
  while (!solid_links.contains(model.links()[static_cast<std::size_t>(link)].name)) {
    const int child = only_child[static_cast<std::size_t>(link)];
    if (child < 0) return -1;
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(child)];
    link = node.link;
    if (node.type == JointType::kFixed) continue;
    if (++movable >= kFreedoms && freedomsOf(model, link) == kFreedoms) return link;
  }
  return -1;
}

}  // namespace

RootedHand cutFloatingBase(const HandModel& model, const std::set<std::string>& solid_links) {
  const int end = endOfFloatingBase(model, solid_links);
  if (end < 0) return {model, std::nullopt};

  // The chain is what links are before its end; links are sorted depth first.
  std::set<std::string> before;
  for (int link = 0; link < end; ++link)
    before.insert(model.links()[static_cast<std::size_t>(link)].name);
  std::vector<Link> carrier_links;
  std::vector<Link> hand_links;
  for (int link = 0; link < model.linkCount(); ++link) {
    const Link& source = model.links()[static_cast<std::size_t>(link)];
    if (link <= end) carrier_links.push_back({source.name, {}, {}});
    if (link >= end) hand_links.push_back(source);
  }
  std::vector<Joint> carrier_joints;
  std::vector<Joint> hand_joints;
  std::set<std::string> carrier_names;
  for (const Joint& joint : model.joints()) {
    const bool carries = before.contains(joint.parent_link);
    (carries ? carrier_joints : hand_joints).push_back(joint);
    if (carries) carrier_names.insert(joint.name);
  }
  const auto crosses = [&](const Joint& joint, bool carries) {
    return joint.mimic && carrier_names.contains(joint.mimic->source_joint) != carries;
  };
  const bool is_coupled =
      std::any_of(carrier_joints.begin(), carrier_joints.end(),
                  [&](const Joint& joint) {
                    return crosses(joint, true);
                  }) ||
      std::any_of(hand_joints.begin(), hand_joints.end(), [&](const Joint& joint) {
        return crosses(joint, false);
      });
  if (is_coupled) return {model, std::nullopt};
  return {HandModel(model.name(), std::move(hand_links), std::move(hand_joints))
              .asMirror(model.isMirror()),
          HandModel(model.name(), std::move(carrier_links), std::move(carrier_joints))};
}

Pose carriedPose(const HandModel& carrier, const Eigen::VectorXd& q) {
  return forwardKinematics(carrier, {Pose::Identity(), q}).back();
}

}  // namespace handgraft::hand
