#include "core/hand/hand_parts.h"

#include <algorithm>
#include <map>
#include <set>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/hand/anatomy.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

/// Who owns a link, if no digit does.
constexpr int kCarrier = -1;  // of the palm, or beside it
constexpr int kPalm = -2;
constexpr int kFirstLoose = -3;  // chains that are no digits: -3, -4, ...

constexpr double kShortestBone = 1e-3;  // m
/// Cosine between a pad's normal and another beyond which that looks from the link's back.
constexpr double kBackCosine = -0.7;
/// Sine between a bone and a normal below which its tangent is mostly noise: 30 degrees.
constexpr double kSteepest = 0.5;

/// The link whose joint moves each link: itself, or what it is fixed to.
std::vector<int> bodiesOf(const HandModel& model) {
  std::vector<int> body(static_cast<std::size_t>(model.linkCount()));
  for (const HandModel::Node& node : model.nodes()) {
    body[static_cast<std::size_t>(node.link)] =
        node.type == JointType::kFixed ? body[static_cast<std::size_t>(node.parent_link)]
                                       : node.link;
  }
  return body;
}

/// The digit of each link, or one of the above.
std::vector<int> ownersOf(const HandModel& model, const Anatomy& anatomy) {
  std::vector<int> owner(static_cast<std::size_t>(model.linkCount()), kCarrier);
  for (const int link : anatomy.palm_links)
    owner[static_cast<std::size_t>(link)] = kPalm;
  for (std::size_t i = 0; i < anatomy.digits.size(); ++i)
    for (const Segment& segment : anatomy.digits[i].segments)
      for (const int link : segment.links)
        owner[static_cast<std::size_t>(link)] = static_cast<int>(i);
  int next_loose = kFirstLoose;
  for (const HandModel::Node& node : model.nodes()) {
    int& mine = owner[static_cast<std::size_t>(node.link)];
    const int parents = owner[static_cast<std::size_t>(node.parent_link)];
    if (mine != kCarrier || parents == kCarrier) continue;
    mine = node.type != JointType::kFixed && parents == kPalm ? next_loose-- : parents;
  }
  return owner;
}

/// Where the bone of `body`, one of the digit's, leads: unit, in S; zero if it has no length.
Eigen::Vector3d boneOf(const Digit& digit, const LinkPoses& X_SL, int body) {
  const Eigen::Vector3d from = X_SL[static_cast<std::size_t>(body)].translation();
  bool is_beyond = false;
  for (const int node : digit.nodes) {
    const int link = node + 1;
    const Eigen::Vector3d along = X_SL[static_cast<std::size_t>(link)].translation() - from;
    if (is_beyond && along.norm() > kShortestBone) return along.normalized();
    is_beyond = is_beyond || link == body;
  }
  const Eigen::Vector3d along = digit.tip - from;
  return along.norm() > kShortestBone ? along.normalized() : Eigen::Vector3d::Zero();
}

}  // namespace

HandParts::HandParts(const HandModel& model, const std::vector<ContactSite>& sites)
    : names_(static_cast<std::size_t>(model.linkCount())),
      pads_(static_cast<std::size_t>(model.linkCount())) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const Anatomy anatomy = anatomyOf(model, X_SL, sites);
  const std::vector<int> owner = ownersOf(model, anatomy);
  const std::vector<int> body = bodiesOf(model);

  // === Names: the digits', sites' on other chains, then numbers
  std::map<int, std::string> name_of;
  std::set<std::string> taken;
  for (const ContactSite& site : sites) {
    const int whose = owner[static_cast<std::size_t>(model.linkIndex(site.link))];
    if (whose <= kFirstLoose) name_of.emplace(whose, site.name);
    taken.insert(site.name);
  }
  for (std::size_t i = 0; i < anatomy.digits.size(); ++i) {
    name_of.emplace(static_cast<int>(i), anatomy.digits[i].name);
    taken.insert(anatomy.digits[i].name);
  }
  int number = 0;
  for (std::size_t link = 0; link < names_.size(); ++link) {
    if (owner[link] == kPalm) names_[link] = "palm";
    if (owner[link] == kCarrier || owner[link] == kPalm) continue;
    std::string& name = name_of[owner[link]];
    while (name.empty()) {
      const std::string next = fmt::format("f{}", ++number);
      if (taken.insert(next).second) name = next;
    }
    names_[link] = name;
  }

  // === Pads: the sites', else the bones'
  for (std::size_t link = 0; link < pads_.size(); ++link) {
    const Eigen::Matrix3d R_LS = X_SL[link].linear().transpose();
    const auto site = std::find_if(sites.begin(), sites.end(), [&](const ContactSite& one) {
      return body[static_cast<std::size_t>(model.linkIndex(one.link))] == body[link];
    });
    if (site != sites.end()) {
      const Eigen::Matrix3d R_LC =
          R_LS * X_SL[static_cast<std::size_t>(model.linkIndex(site->link))].linear();
      pads_[link] = Pad{R_LC * site->n_L, R_LC * site->direction_L};
      continue;
    }
    if (owner[link] < 0) continue;
    const Digit& digit = anatomy.digits[static_cast<std::size_t>(owner[link])].digit;
    const Eigen::Vector3d bone_S = boneOf(digit, X_SL, body[link]);
    const Eigen::Vector3d n_S = digit.flexion_axis.cross(bone_S);
    if (n_S.norm() < kSteepest) continue;
    pads_[link] = Pad{R_LS * n_S.normalized(), -(R_LS * bone_S)};
  }
}

std::optional<Eigen::Vector3d> HandParts::towardsWrist(int link,
                                                       const Eigen::Vector3d& n_L) const {
  HANDGRAFT_REQUIRE(link >= 0 && link < static_cast<int>(pads_.size()));
  const std::optional<Pad>& pad = pads_[static_cast<std::size_t>(link)];
  if (!pad) return std::nullopt;
  const Eigen::Vector3d& d_L = pad->towards_wrist_L;
  const Eigen::Vector3d tangent = d_L - d_L.dot(n_L) * n_L;
  if (tangent.norm() > kSteepest) return tangent.normalized();
  // The finger stands on the surface.
  if (pad->n_L.dot(n_L) < kBackCosine) return std::nullopt;
  return Eigen::Quaterniond::FromTwoVectors(pad->n_L, n_L) * d_L;
}

}  // namespace handgraft::hand
