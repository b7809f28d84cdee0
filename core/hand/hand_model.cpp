#include "core/hand/hand_model.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"

namespace handgraft::hand {

namespace {

using NameIndex = std::unordered_map<std::string, int>;

/// Angles and lengths below this cannot be told from a frame's round-off.
constexpr double kRotationTolerance = 1e-6;

template <class Named>
NameIndex indexNames(const std::vector<Named>& things, const char* kind) {
  NameIndex index;
  for (std::size_t i = 0; i < things.size(); ++i) {
    if (things[i].name.empty()) rejectInput("{} {} has no name", kind, i);
    if (!index.emplace(things[i].name, static_cast<int>(i)).second)
      rejectInput("{} {} is there twice: names must differ", kind, quoted(things[i].name));
  }
  return index;
}

/// "'a', 'b', 'c' and 4 more"
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 24;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i == 0 ? "" : ", ") + quoted(names[i]);
  if (names.size() > kMost) text += fmt::format(" and {} more", names.size() - kMost);
  return text.empty() ? "none" : text;
}

void checkNumbers(Joint& joint) {
  const std::string name = quoted(joint.name);
  if (!joint.X_PJ.matrix().allFinite()) rejectInput("joint {}: its origin is not finite", name);
  const Eigen::Matrix3d R = joint.X_PJ.linear();
  if (!(R.transpose() * R).isIdentity(kRotationTolerance) || R.determinant() < 0.0)
    rejectInput("joint {}: the rotation of its origin is not a proper rotation", name);
  if (joint.type == JointType::kFixed) return;

  const double length = joint.axis_J.stableNorm();
  if (!std::isfinite(length) || length < 1e-12)
    rejectInput("joint {}: axis ({} {} {}) has no direction", name, joint.axis_J.x(),
                joint.axis_J.y(), joint.axis_J.z());
  joint.axis_J /= length;
  if (std::isnan(joint.lower) || std::isnan(joint.upper))
    rejectInput("joint {}: a limit is not a number", name);
  if (joint.lower > joint.upper || joint.lower == std::numeric_limits<double>::infinity() ||
      joint.upper == -std::numeric_limits<double>::infinity())
    rejectInput("joint {}: its lower limit {} is above its upper limit {}", name, joint.lower,
                joint.upper);
  for (const JointNumber& number : kJointNumbers) {
    const double value = joint.*number.value;
    if (number.urdf_element != nullptr && !(std::isfinite(value) && value >= 0.0))
      rejectInput("joint {}: {} {} must be finite and not negative", name, number.name, value);
  }
  if (joint.mimic &&
      !(std::isfinite(joint.mimic->multiplier) && std::isfinite(joint.mimic->offset)))
    rejectInput("joint {}: its mimic multiplier and offset must be finite", name);
}

/// The joint that carries each link, -1 for the root.
std::vector<int> findCarriers(const std::vector<Link>& links,
                              const std::vector<Joint>& joints,
                              const NameIndex& link_index) {
  std::vector<int> carrier(links.size(), -1);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    if (!link_index.contains(joint.parent_link))
      rejectInput("joint {}: its parent link {} does not exist", quoted(joint.name),
                  quoted(joint.parent_link));
    const auto child = link_index.find(joint.child_link);
    if (child == link_index.end())
      rejectInput("joint {}: its child link {} does not exist", quoted(joint.name),
                  quoted(joint.child_link));
    int& slot = carrier[static_cast<std::size_t>(child->second)];
    if (slot >= 0)
      rejectInput("link {} has two parents, joints {} and {}: a hand is a tree, without loops",
                  quoted(joint.child_link), quoted(joints[static_cast<std::size_t>(slot)].name),
                  quoted(joint.name));
    slot = static_cast<int>(j);
  }
  return carrier;
}

/// Names the joints of a loop, given a link that no root reaches.
[[noreturn]] void rejectLoop(int link,
                             const std::vector<Joint>& joints,
                             const NameIndex& link_index,
                             const std::vector<int>& carrier) {
  std::vector<char> seen(carrier.size(), 0);
  const auto parent_of = [&](int child) {
    return link_index.at(
        joints[static_cast<std::size_t>(carrier[static_cast<std::size_t>(child)])].parent_link);
  };
  // Walking towards the parents must end in the loop; from there once around it.
  while (seen[static_cast<std::size_t>(link)] == 0) {
    seen[static_cast<std::size_t>(link)] = 1;
    link = parent_of(link);
  }
  std::vector<std::string> names;
  int walker = link;
  do {
    names.push_back(
        joints[static_cast<std::size_t>(carrier[static_cast<std::size_t>(walker)])].name);
    walker = parent_of(walker);
  } while (walker != link);
  rejectInput("joints {} form a loop: a hand is a tree, without loops", listed(names));
}

/// Links in depth-first order, children in the order of their joints, so that parents come
/// first and the links of one finger stay together.
std::vector<int> sortLinks(const std::vector<Link>& links,
                           const std::vector<Joint>& joints,
                           const NameIndex& link_index,
                           const std::vector<int>& carrier) {
  std::vector<std::string> roots;
  int root = -1;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (carrier[i] >= 0) continue;
    roots.push_back(links[i].name);
    if (root < 0) root = static_cast<int>(i);
  }
  if (roots.empty()) rejectLoop(0, joints, link_index, carrier);
  if (roots.size() > 1)
    rejectInput("the links {} hang on no joint: a hand has exactly one root", listed(roots));

  std::vector<std::vector<int>> children(links.size());
  for (const Joint& joint : joints)
    children[static_cast<std::size_t>(link_index.at(joint.parent_link))].push_back(
        link_index.at(joint.child_link));

  std::vector<int> order;
  std::vector<char> reached(links.size(), 0);
  std::vector<int> stack{root};
  while (!stack.empty()) {
    const auto link = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    order.push_back(static_cast<int>(link));
    reached[link] = 1;
    stack.insert(stack.end(), children[link].rbegin(), children[link].rend());
  }
  for (std::size_t i = 0; i < links.size(); ++i)
    if (reached[i] == 0) rejectLoop(static_cast<int>(i), joints, link_index, carrier);
  return order;
}

/// A joint as a function of an independent one: q = multiplier * q[source] + offset.
struct Follow {
  int source = -1;
  double multiplier = 1.0;
  double offset = 0.0;
};

/// Follows a chain of mimics to the joint that moves by itself.
Follow resolveMimic(int joint, const std::vector<Joint>& joints, const NameIndex& joint_index) {
  Follow follow{joint, 1.0, 0.0};
  std::vector<std::string> chain;
  while (joints[static_cast<std::size_t>(follow.source)].mimic) {
    const Joint& follower = joints[static_cast<std::size_t>(follow.source)];
    chain.push_back(follower.name);
    if (chain.size() > joints.size())
      rejectInput("joint {}: its mimics form a loop",
                  quoted(joints[static_cast<std::size_t>(joint)].name));
    const Mimic& mimic = *follower.mimic;
    const auto found = joint_index.find(mimic.source_joint);
    if (found == joint_index.end())
      rejectInput("joint {} mimics {}, which does not exist", quoted(follower.name),
                  quoted(mimic.source_joint));
    if (joints[static_cast<std::size_t>(found->second)].type == JointType::kFixed)
      rejectInput("joint {} mimics {}, which is fixed", quoted(follower.name),
                  quoted(mimic.source_joint));
    follow.offset += follow.multiplier * mimic.offset;
    follow.multiplier *= mimic.multiplier;
    follow.source = found->second;
  }
  if (!std::isfinite(follow.multiplier) || !std::isfinite(follow.offset))
    rejectInput("joint {}: its mimics multiply beyond all bounds",
                quoted(joints[static_cast<std::size_t>(joint)].name));
  return follow;
}

/// Narrows the limits of what a joint follows to where the joint keeps its own, if any such
/// place is left.
void narrowToFollower(const Joint& joint, const Follow& follow, double& lower, double& upper) {
  double low = (joint.lower - follow.offset) / follow.multiplier;
  double high = (joint.upper - follow.offset) / follow.multiplier;
  if (low > high) std::swap(low, high);
  low = std::max(low, lower);
  high = std::min(high, upper);
  if (low < high) {
    lower = low;
    upper = high;
  }
}

}  // namespace

HandModel::HandModel(std::string name, std::vector<Link> links, std::vector<Joint> joints)
    : name_(std::move(name)), joints_(std::move(joints)) {
  if (links.empty()) rejectInput("hand {} has no links", quoted(name_));

  // === The tree
  const NameIndex link_index = indexNames(links, "link");
  const NameIndex joint_index = indexNames(joints_, "joint");
  for (Joint& joint : joints_) {
    if (joint.type == JointType::kFixed) joint.mimic.reset();
    checkNumbers(joint);
  }
  const std::vector<int> carrier = findCarriers(links, joints_, link_index);
  const std::vector<int> order = sortLinks(links, joints_, link_index, carrier);
  std::vector<int> rank(links.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);

  // === Degrees of freedom: movable joints that follow no other
  std::vector<int> dof_of_joint(joints_.size(), -1);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (joints_[j].type == JointType::kFixed || joints_[j].mimic) continue;
    dof_of_joint[j] = static_cast<int>(dof_joints_.size());
    dof_joints_.push_back(static_cast<int>(j));
  }
  lower_.resize(dofCount());
  upper_.resize(dofCount());
  for (int i = 0; i < dofCount(); ++i) {
    lower_[i] = dofJoint(i).lower;
    upper_[i] = dofJoint(i).upper;
  }

  // === Nodes, in the order of the sorted links
  nodes_.reserve(links.size() - 1);
  for (std::size_t i = 1; i < order.size(); ++i) {
    const int joint_number = carrier[static_cast<std::size_t>(order[i])];
    const Joint& joint = joints_[static_cast<std::size_t>(joint_number)];
    Node node;
    node.link = static_cast<int>(i);
    node.parent_link = rank[static_cast<std::size_t>(link_index.at(joint.parent_link))];
    node.type = joint.type;
    node.X_PJ = joint.X_PJ;
    node.axis_J = joint.axis_J;
    node.joint_name = joint.name;
    if (joint.type != JointType::kFixed) {
      const Follow follow = resolveMimic(joint_number, joints_, joint_index);
      node.dof = dof_of_joint[static_cast<std::size_t>(follow.source)];
      node.multiplier = follow.multiplier;
      node.offset = follow.offset;
      if (joint.mimic && node.multiplier != 0.0)
        narrowToFollower(joint, follow, lower_[node.dof], upper_[node.dof]);
    }
    nodes_.push_back(std::move(node));
  }

  links_.reserve(links.size());
  for (const int link : order)
    links_.push_back(std::move(links[static_cast<std::size_t>(link)]));
  rest_ = zeroPose();
}

int HandModel::mimicCount() const {
  return static_cast<int>(std::count_if(joints_.begin(), joints_.end(), [](const Joint& j) {
    return j.mimic.has_value();
  }));
}

const Joint& HandModel::dofJoint(int dof) const {
  HANDGRAFT_REQUIRE(dof >= 0 && dof < dofCount());
  return joints_[static_cast<std::size_t>(dof_joints_[static_cast<std::size_t>(dof)])];
}

std::vector<std::string> HandModel::dofNames() const {
  std::vector<std::string> names;
  names.reserve(dof_joints_.size());
  for (int i = 0; i < dofCount(); ++i)
    names.push_back(dofJoint(i).name);
  return names;
}

std::optional<int> HandModel::maybeLinkIndex(const std::string& link_name) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].name == link_name) return static_cast<int>(i);
  return std::nullopt;
}

int HandModel::linkIndex(const std::string& link_name) const {
  if (const auto index = maybeLinkIndex(link_name)) return *index;
  std::vector<std::string> names;
  for (const Link& link : links_)
    names.push_back(link.name);
  rejectInput("hand {} has no link {}; it has {}", quoted(name_), quoted(link_name),
              listed(names));
}

int HandModel::dofIndex(const std::string& joint_name) const {
  for (int i = 0; i < dofCount(); ++i)
    if (dofJoint(i).name == joint_name) return i;
  for (const Joint& joint : joints_) {
    if (joint.name != joint_name) continue;
    if (joint.mimic)
      rejectInput("joint {} of hand {} follows joint {} and cannot be moved by itself",
                  quoted(joint_name), quoted(name_), quoted(joint.mimic->source_joint));
    rejectInput("joint {} of hand {} is fixed", quoted(joint_name), quoted(name_));
  }
  rejectInput("hand {} has no joint {}; its movable joints are {}", quoted(name_),
              quoted(joint_name), listed(dofNames()));
}

Eigen::VectorXd HandModel::zeroPose() const {
  return Eigen::VectorXd::Zero(dofCount()).cwiseMax(lower_).cwiseMin(upper_);
}

HandModel HandModel::asMirror(bool is_mirror) const {
  HandModel other = *this;
  other.is_mirror_ = is_mirror;
  return other;
}

HandModel HandModel::withRestPose(const Eigen::VectorXd& q) const {
  if (q.size() != dofCount())
    rejectInput("hand {}: a rest pose of {} values; it has {} joints", quoted(name_), q.size(),
                dofCount());
  for (int dof = 0; dof < dofCount(); ++dof) {
    if (!std::isfinite(q[dof]) || q[dof] < lower_[dof] || q[dof] > upper_[dof])
      rejectInput("rest pose of hand {}: joint {} is {}; permitted are {} to {}", quoted(name_),
                  quoted(dofJoint(dof).name), q[dof], lower_[dof], upper_[dof]);
  }
  HandModel other = *this;
  other.rest_ = q;
  return other;
}

}  // namespace handgraft::hand
