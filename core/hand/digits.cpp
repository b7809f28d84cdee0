#include "core/hand/digits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/hand/part_words.h"

namespace handgraft::hand {

const char* nameOf(Chirality side) {
  switch (side) {
    case Chirality::kUnknown:
      return "";
    case Chirality::kRight:
      return "right";
    case Chirality::kLeft:
      return "left";
  }
  throw BrokenContract("a side of no hand");
}

Chirality sideNamed(const std::string& text, const char* field) {
  for (const Chirality side : {Chirality::kRight, Chirality::kLeft})
    if (text == nameOf(side)) return side;
  rejectInput("field '{}' is {}; permitted are 'right' and 'left'", field, quoted(text));
}

namespace {

/// Joints whose axis leans less than this from the last one's bend the finger the same way.
constexpr double kParallelCosine = 0.8;
/// Share of the distance within which points are equally far.
constexpr double kEquallyFar = 1e-3;
/// Share of the range by which one side must outweigh the other to call it the closing side.
constexpr double kClearAsymmetry = 0.1;

/// Joints that are nearer each other are one knuckle; what is smaller is no fingertip.
constexpr double kShortBone = 0.005;  // m

/// rad; a finger that is so much straighter where its limits have it closed than where they
/// have it open is shut there.
constexpr double kStraighter = 0.35;

/// Sine of the least angle between where a jaw slides and where it points.
constexpr double kAcross = 0.6;
/// m; jaws nearer than that in the direction of their slide do not say to which side they
/// close.
constexpr double kJawsApart = 1e-3;  // m

/// Cosine; where limits do not tell, a digit that leans more than that from the others closes
/// the other way round.
constexpr double kTowardsOthers = 0.5;

/// m; a bar of a mechanism lies so near the plane in which its finger moves.
constexpr double kInPlane = 0.008;  // m

const HandModel::Node& nodeOf(const HandModel& model, int link) {
  return model.nodes()[static_cast<std::size_t>(link - 1)];
}

/// Links from `link` up to the root, itself first.
std::vector<int> pathToRoot(const HandModel& model, int link) {
  std::vector<int> path{link};
  while (link != 0) {
    link = nodeOf(model, link).parent_link;
    path.push_back(link);
  }
  return path;
}

/// Whether a link has a surface as large as a fingertip's.
bool hasBody(const Link& link) {
  const std::vector<Shape>& shapes = link.surface();
  return std::any_of(shapes.begin(), shapes.end(), [](const Shape& shape) {
    const auto& p_L = shape.mesh_L.vertices();
    return (p_L.rowwise().maxCoeff() - p_L.rowwise().minCoeff()).maxCoeff() > kShortBone;
  });
}

/// Links with a body that carry no other such link by a joint that moves.
std::vector<int> lastMovingLinks(const HandModel& model) {
  const auto count = static_cast<std::size_t>(model.linkCount());
  // The movable joint that carries each link, as the child link of that joint; 0 is the root.
  std::vector<int> body(count, 0);
  std::vector<char> has_body(count, 0);
  std::vector<char> carries(count, 0);
  for (std::size_t link = 0; link < count; ++link) {
    if (link > 0) {
      const HandModel::Node& node = nodeOf(model, static_cast<int>(link));
      body[link] = node.type == JointType::kFixed
                       ? body[static_cast<std::size_t>(node.parent_link)]
                       : static_cast<int>(link);
    }
    if (hasBody(model.links()[link])) has_body[static_cast<std::size_t>(body[link])] = 1;
  }
  for (std::size_t link = count; link-- > 1;) {
    if (body[link] != static_cast<int>(link)) continue;
    const auto below = static_cast<std::size_t>(
        body[static_cast<std::size_t>(nodeOf(model, static_cast<int>(link)).parent_link)]);
    if (has_body[link] != 0 || carries[link] != 0) carries[below] = 1;
  }
  std::vector<int> last;
  for (std::size_t link = 1; link < count; ++link)
    if (body[link] == static_cast<int>(link) && has_body[link] != 0 && carries[link] == 0)
      last.push_back(static_cast<int>(link));
  return last;
}

int commonAncestor(const HandModel& model, const std::vector<int>& links) {
  if (links.size() < 2) return 0;
  std::vector<int> shared = pathToRoot(model, links.front());
  for (const int link : links) {
    const std::vector<int> path = pathToRoot(model, link);
    std::erase_if(shared, [&](int candidate) {
      return std::find(path.begin(), path.end(), candidate) == path.end();
    });
  }
  return shared.front();
}

/// How much farther a node bends one way than the other, in [-1, 1]; 0 without limits.
double asymmetryOf(const HandModel& model, const HandModel::Node& node) {
  const double lower = model.lower()[node.dof];
  const double upper = model.upper()[node.dof];
  if (!std::isfinite(lower) || !std::isfinite(upper) || !(upper > lower)) return 0.0;
  const double asymmetry = std::clamp((upper + lower) / (upper - lower), -1.0, 1.0);
  return node.multiplier < 0.0 ? -asymmetry : asymmetry;
}

/// The four-fingered hand whose links are numbered, link_0.0 to link_15.0: its thumb comes
/// last; which side the others are counted from depends on the hand.
bool isNumberedThumb(const HandModel& model, const std::string& link_name) {
  return model.maybeLinkIndex("link_0.0") && link_name == "link_15.0";
}

/// The digit that most of the names say.
std::string hintIn(const HandModel& model, const std::vector<int>& links_from_tip) {
  constexpr int kClear = 100;  // one clear name outweighs all vague ones
  std::vector<std::pair<std::string, int>> votes;
  const auto count = [&](const std::string& name) {
    const PartWords words = partWordsOf(name);
    if (words.digit.empty() || words.digit == "palm") return;
    auto vote = std::find_if(votes.begin(), votes.end(), [&](const auto& one) {
      return one.first == words.digit;
    });
    if (vote == votes.end()) vote = votes.insert(votes.end(), {words.digit, 0});
    vote->second += words.is_vague ? 1 : kClear;
  };
  for (const int link : links_from_tip) {
    const std::string& name = model.links()[static_cast<std::size_t>(link)].name;
    if (isNumberedThumb(model, name)) return "thumb";
    count(name);
    count(nodeOf(model, link).joint_name);
  }
  const auto most =
      std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  return most == votes.end() ? "" : most->first;
}

/// `users` holds how many digits each link carries: what several share is no finger's own.
Digit makeDigit(const HandModel& model,
                const LinkPoses& X_SL,
                int last_link,
                int palm_link,
                const std::vector<int>& users) {
  Digit digit;
  digit.tip_links = rigidGroupOf(model, last_link);
  std::vector<int> named(digit.tip_links.rbegin(), digit.tip_links.rend());
  for (const int link : pathToRoot(model, last_link)) {
    if (link == palm_link || link == 0) break;
    const bool is_shared = users[static_cast<std::size_t>(link)] > 1;
    std::vector<int>& nodes = is_shared ? digit.carriers : digit.nodes;
    if (nodeOf(model, link).type != JointType::kFixed) nodes.insert(nodes.begin(), link - 1);
    if (link != last_link && !is_shared) named.push_back(link);
  }
  digit.hint = hintIn(model, named);
  digit.base = X_SL[static_cast<std::size_t>(digit.nodes.front()) + 1].translation();
  digit.last_joint = X_SL[static_cast<std::size_t>(last_link)].translation();

  // What slides reaches as far as it does across its slide: a rack is no finger.
  const HandModel::Node& last = nodeOf(model, last_link);
  const auto across = [&](Eigen::Vector3d way) {
    if (last.type != JointType::kPrismatic) return way;
    const Eigen::Vector3d slide =
        X_SL[static_cast<std::size_t>(last_link)].linear() * last.axis_J;
    return Eigen::Vector3d(way - way.dot(slide) * slide);
  };
  const auto reach = [&](const Eigen::Vector3d& p) {
    return across(p - digit.last_joint).norm();
  };
  std::vector<Eigen::Vector3d> surface;
  double farthest = 0.0;
  for (const int link : digit.tip_links) {
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface()) {
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v) {
        surface.push_back(X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v));
        farthest = std::max(farthest, reach(surface.back()));
      }
    }
  }
  // A tip that ends in a face has corners equally far: its middle, not one of them.
  double count = 0.0;
  for (const Eigen::Vector3d& p : surface) {
    if (reach(p) < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip += p;
    count += 1.0;
  }
  if (count > 0.0) digit.tip /= count;
  for (const Eigen::Vector3d& p : surface) {
    if (reach(p) < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip_radius = std::max(digit.tip_radius, (p - digit.tip).norm());
  }
  // What is the same all round its slide points nowhere.
  const Eigen::Vector3d way = across(digit.tip - digit.last_joint);
  if (way.norm() > kEquallyFar * farthest) digit.outward = way.normalized();
  return digit;
}

/// A joint of a digit that bends it as the last one does.
struct Bend {
  int node = 0;
  double sign = 1.0;  ///< of its axis beside the digit's
};

/// From the last one inwards, without and with those of its carriers.
std::vector<Bend> bendsOf(const HandModel& model,
                          const LinkPoses& X_SL,
                          const std::vector<int>& nodes,
                          const Eigen::Vector3d& flexion_axis) {
  std::vector<Bend> bends;
  for (auto index = nodes.rbegin(); index != nodes.rend(); ++index) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(*index)];
    if (node.type != JointType::kRevolute) continue;
    const double cosine =
        flexion_axis.dot(X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J);
    if (std::abs(cosine) > kParallelCosine)
      bends.push_back({*index, cosine > 0.0 ? 1.0 : -1.0});
  }
  return bends;
}

void turnRound(Digit& digit) {
  digit.closing = -digit.closing;
  digit.bone_closing = -digit.bone_closing;
  digit.flexion_axis = -digit.flexion_axis;
}

/// The axis of the last revolute joint, turned so that it closes; returns how clear that is.
double orientFlexion(const HandModel& model, const LinkPoses& X_SL, Digit& digit) {
  for (const int index : digit.nodes) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(index)];
    if (node.type == JointType::kRevolute)
      digit.flexion_axis = X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J;
  }
  double asymmetry = 0.0;
  double of_first = 0.0;
  const auto count = [&](const Bend& bend) {
    of_first =
        bend.sign * asymmetryOf(model, model.nodes()[static_cast<std::size_t>(bend.node)]);
    asymmetry += of_first;
  };
  std::vector<Eigen::Vector3d> joints{digit.tip};  // from there inwards
  for (const Bend& bend : bendsOf(model, X_SL, digit.nodes, digit.flexion_axis)) {
    count(bend);
    digit.knuckle = X_SL[static_cast<std::size_t>(bend.node) + 1].translation();
    joints.push_back(digit.knuckle);
  }
  for (const Bend& bend : bendsOf(model, X_SL, digit.carriers, digit.flexion_axis))
    count(bend);
  // Joints that undo each other's turn keep a gripper's pads parallel: the first one moves
  // them.
  if (std::abs(asymmetry) < kClearAsymmetry) asymmetry = of_first;
  if (asymmetry < 0.0) digit.flexion_axis = -digit.flexion_axis;
  const Eigen::Vector3d motion = digit.flexion_axis.cross(digit.outward);
  if (motion.norm() > 1e-6) digit.closing = motion.normalized();
  const auto next = std::find_if(joints.rbegin(), joints.rend(), [&](const auto& joint) {
    return (joint - digit.knuckle).norm() > kShortBone;
  });
  digit.bone_outward =
      next != joints.rend() ? (*next - digit.knuckle).normalized() : digit.outward;
  const Eigen::Vector3d bone_motion = digit.flexion_axis.cross(digit.bone_outward);
  digit.bone_closing = bone_motion.norm() > 1e-6 ? bone_motion.normalized() : digit.closing;
  return std::abs(asymmetry);
}

/// A digit where all joints are 0, which is what its limits are told from: the skin may be
/// made at another pose.
struct AtZero {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  Eigen::Vector3d flexion_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d closing = Eigen::Vector3d::Zero();  ///< of the tip about the last joint
};

AtZero atZero(const HandModel& model,
              const LinkPoses& X_SL,
              const LinkPoses& X_0,
              const Digit& digit) {
  const auto moved = [&](int link) {
    return Pose(X_0[static_cast<std::size_t>(link)] *
                inverse(X_SL[static_cast<std::size_t>(link)]));
  };
  AtZero zero;
  zero.base = X_0[static_cast<std::size_t>(digit.nodes.front()) + 1].translation();
  const Pose of_tip = moved(digit.tip_links.front());
  zero.tip = of_tip * digit.tip;
  zero.closing = of_tip.linear() * digit.closing;
  for (const int index : digit.nodes)
    if (model.nodes()[static_cast<std::size_t>(index)].type == JointType::kRevolute)
      zero.flexion_axis = moved(index + 1).linear() * digit.flexion_axis;
  return zero;
}

/// Whether a finger is bent at 0 and straightens where its limits have it closed: one that is
/// shut at 0, and opens.
bool isShutAtZero(const HandModel& model,
                  const LinkPoses& X_0,
                  const Digit& digit,
                  const AtZero& zero) {
  const Eigen::Vector3d& axis = zero.flexion_axis;
  const auto in_plane = [&](const Eigen::Vector3d& way) {
    return Eigen::Vector3d(way - way.dot(axis) * axis);
  };
  const Eigen::VectorXd q_0 = model.zeroPose();
  double open = 0.0;
  double closed = 0.0;
  Eigen::Vector3d end = zero.tip;
  const std::vector<Bend> bends = bendsOf(model, X_0, digit.nodes, axis);
  for (std::size_t i = 0; i + 1 < bends.size(); ++i) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(bends[i].node)];
    const Eigen::Vector3d joint = X_0[static_cast<std::size_t>(node.link)].translation();
    const Eigen::Vector3d before =
        in_plane(joint - X_0[static_cast<std::size_t>(bends[i + 1].node) + 1].translation());
    const Eigen::Vector3d after = in_plane(end - joint);
    if (before.norm() < kShortBone || after.norm() < kShortBone) return false;
    end = joint;
    const double bend = std::atan2(axis.dot(before.cross(after)), before.dot(after));
    const double turn = bends[i].sign * node.multiplier;
    const double a = turn * (model.lower()[node.dof] - q_0[node.dof]);
    const double b = turn * (model.upper()[node.dof] - q_0[node.dof]);
    if (!std::isfinite(a) || !std::isfinite(b)) return false;
    const auto [back, forth] = std::minmax(a, b);
    if (forth < -back) return false;  // it undoes the first joint's turn: a pad kept parallel
    open += bend + back;
    closed += bend + forth;
  }
  return open < -kStraighter && std::abs(open) > std::abs(closed) + kStraighter;
}

/// Where a digit slides, if it does so across the way it points; zero else.
Eigen::Vector3d slideOf(const HandModel& model, const LinkPoses& X_SL, const Digit& digit) {
  for (auto index = digit.nodes.rbegin(); index != digit.nodes.rend(); ++index) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(*index)];
    if (node.type != JointType::kPrismatic) continue;
    Eigen::Vector3d slide = X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J;
    if (slide.cross(digit.outward).norm() > kAcross) return slide;
  }
  return Eigen::Vector3d::Zero();
}

/// Jaws close towards the other digits; false for one that does not tell.
bool orientJaw(const Eigen::Vector3d& slide, const Eigen::Vector3d& to_others, Digit& digit) {
  const double way = slide.dot(to_others);
  if (std::abs(way) < kJawsApart) return false;
  const Eigen::Vector3d closing = way > 0.0 ? slide : Eigen::Vector3d(-slide);
  digit.closing = (closing - closing.dot(digit.outward) * digit.outward).normalized();
  digit.flexion_axis = digit.outward.cross(digit.closing);
  digit.knuckle = digit.last_joint;
  digit.bone_outward = digit.outward;
  digit.bone_closing = digit.closing;
  return true;
}

/// Whether a chain of one joint is a bar that guides a finger, as the inner knuckles of
/// grippers with parallel jaws: it moves beside the finger in one plane, by the same motor and
/// to the same side, and ends before it does.
bool isBarOf(const HandModel& model,
             const LinkPoses& X_SL,
             const Digit& bar,
             const Digit& finger) {
  const auto dof_of = [&](const Digit& digit) {
    return model.nodes()[static_cast<std::size_t>(digit.nodes.front())].dof;
  };
  if (bar.nodes.size() != 1 || finger.nodes.size() + finger.carriers.size() < 2 ||
      dof_of(bar) != dof_of(finger))
    return false;
  const Eigen::Vector3d& axis = finger.flexion_axis;
  // A finger that forks has its tips to both sides of the plane.
  const bool forks = !finger.carriers.empty();
  const Eigen::Vector3d base =
      forks ? X_SL[static_cast<std::size_t>(finger.carriers.front()) + 1].translation()
            : finger.base;
  return std::abs(bar.flexion_axis.dot(axis)) > kParallelCosine &&
         bar.closing.dot(finger.closing) > 0.0 &&
         std::abs((bar.base - base).dot(axis)) < kInPlane &&
         (forks || std::abs((bar.tip - finger.tip).dot(axis)) < kInPlane) &&
         (bar.tip - bar.base).norm() < (finger.tip - base).norm();
}

/// Digits whose limits do not say to which side they close: as the others do, or, where none
/// says it, towards each other: fingers with symmetric limits around a base.
void orientUnclear(const std::vector<std::size_t>& unclear,
                   const std::vector<AtZero>& at_zero,
                   std::vector<Digit>& digits) {
  Eigen::Vector3d consensus = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < digits.size(); ++i)
    if (std::find(unclear.begin(), unclear.end(), i) == unclear.end())
      consensus += digits[i].closing;
  if (unclear.size() < digits.size()) {
    for (const std::size_t i : unclear)
      if (digits[i].closing.dot(consensus) < 0.0) turnRound(digits[i]);
    return;
  }
  for (std::size_t i = 0; i < digits.size(); ++i) {
    Eigen::Vector3d to_others = Eigen::Vector3d::Zero();
    for (const AtZero& other : at_zero)
      to_others += other.base - at_zero[i].base;
    // Fingers in a row stand beside each other.
    if (at_zero[i].closing.dot(to_others.normalized()) < -kTowardsOthers) turnRound(digits[i]);
  }
}

/// Of two digits each closes towards the other, whatever their limits say: a gripper may be
/// shut where its joints are 0.
void orientPair(const std::vector<AtZero>& at_zero, std::vector<Digit>& digits) {
  if (digits.size() != 2) return;
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d to_other = (at_zero[1 - i].tip - at_zero[i].tip).normalized();
    if (at_zero[i].closing.dot(to_other) < -kTowardsOthers) turnRound(digits[i]);
  }
}

void orientJaws(const HandModel& model, const LinkPoses& X_SL, std::vector<Digit>& digits) {
  std::vector<std::size_t> still;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (!digits[i].closing.isZero()) continue;
    const Eigen::Vector3d slide = slideOf(model, X_SL, digits[i]);
    Eigen::Vector3d to_others = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < digits.size(); ++j)
      if (j != i) to_others += digits[j].tip - digits[i].tip;
    if (slide.isZero() || !orientJaw(slide, to_others, digits[i])) still.push_back(i);
  }
  for (auto i = still.rbegin(); i != still.rend(); ++i)
    digits.erase(digits.begin() + static_cast<std::ptrdiff_t>(*i));
}

}  // namespace

std::vector<int> rigidGroupOf(const HandModel& model, int link) {
  std::vector<int> group{link};
  for (const HandModel::Node& node : model.nodes()) {
    if (node.type == JointType::kFixed &&
        std::find(group.begin(), group.end(), node.parent_link) != group.end())
      group.push_back(node.link);
  }
  return group;
}

std::vector<int> palmBodyOf(const HandModel& model, int palm_link) {
  std::vector<int> body{palm_link};
  const auto link_at = [&](int link) -> const Link& {
    return model.links()[static_cast<std::size_t>(link)];
  };
  // A palm with both looks and geometry to collide wears what is only to be seen.
  const bool wears =
      !link_at(palm_link).visuals.empty() && !link_at(palm_link).collisions.empty();
  for (const int link : rigidGroupOf(model, palm_link)) {
    const bool is_worn =
        wears && link_at(link).collisions.empty() && !link_at(link).visuals.empty();
    if (link != palm_link && !is_worn) body.push_back(link);
  }
  return body;
}

Digits findDigits(const HandModel& model, const LinkPoses& X_SL) {
  Digits result;
  const std::vector<int> last_links = lastMovingLinks(model);
  result.palm_link = commonAncestor(model, last_links);
  std::vector<int> users(static_cast<std::size_t>(model.linkCount()), 0);
  for (const int last : last_links)
    for (const int link : pathToRoot(model, last))
      ++users[static_cast<std::size_t>(link)];
  result.palm_links = palmBodyOf(model, result.palm_link);
  const std::vector<int> above = pathToRoot(model, result.palm_link);
  for (const HandModel::Node& node : model.nodes()) {
    const bool is_above = std::find(above.begin(), above.end(), node.link) != above.end();
    if (is_above || node.type == JointType::kFixed ||
        users[static_cast<std::size_t>(node.link)] < 2)
      continue;
    const std::vector<int> group = rigidGroupOf(model, node.link);
    result.palm_links.insert(result.palm_links.end(), group.begin(), group.end());
  }

  LinkPoses X_0;
  forwardKinematics(model, Pose::Identity(), model.zeroPose(), X_0);
  std::vector<std::size_t> unclear;
  for (const int link : last_links) {
    Digit digit = makeDigit(model, X_SL, link, result.palm_link, users);
    const double clarity = orientFlexion(model, X_SL, digit);
    if (!digit.closing.isZero() && clarity < kClearAsymmetry)
      unclear.push_back(result.digits.size());
    if (isShutAtZero(model, X_0, digit, atZero(model, X_SL, X_0, digit))) turnRound(digit);
    result.digits.push_back(std::move(digit));
  }

  const auto at_zero = [&] {
    std::vector<AtZero> all;
    for (const Digit& digit : result.digits)
      all.push_back(atZero(model, X_SL, X_0, digit));
    return all;
  };
  orientUnclear(unclear, at_zero(), result.digits);
  orientJaws(model, X_SL, result.digits);
  const std::vector<Digit> all = result.digits;
  std::erase_if(result.digits, [&](const Digit& digit) {
    return std::any_of(all.begin(), all.end(), [&](const Digit& finger) {
      return isBarOf(model, X_SL, digit, finger);
    });
  });
  orientPair(at_zero(), result.digits);
  return result;
}

}  // namespace handgraft::hand
