#include "core/hand/digit_closing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace handgraft::hand {

namespace {

/// Share of the range by which one side must outweigh the other to call it the closing side.
constexpr double kClearAsymmetry = 0.1;

/// Joints that are nearer each other are one knuckle.
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

/// How much farther a node bends one way than the other, in [-1, 1]; 0 without limits.
double asymmetryOf(const HandModel& model, const HandModel::Node& node) {
  const double lower = model.lower()[node.dof];
  const double upper = model.upper()[node.dof];
  if (!std::isfinite(lower) || !std::isfinite(upper) || !(upper > lower)) return 0.0;
  const double asymmetry = std::clamp((upper + lower) / (upper - lower), -1.0, 1.0);
  return node.multiplier < 0.0 ? -asymmetry : asymmetry;
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
    if (std::abs(cosine) > kBendAlike) bends.push_back({*index, cosine > 0.0 ? 1.0 : -1.0});
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
              const LinkPoses& X_HL,
              const Digit& digit) {
  const auto moved = [&](int link) {
    return Pose(X_HL[static_cast<std::size_t>(link)] *
                inverse(X_SL[static_cast<std::size_t>(link)]));
  };
  AtZero zero;
  zero.base = X_HL[static_cast<std::size_t>(digit.nodes.front()) + 1].translation();
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
                  const LinkPoses& X_HL,
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
  const std::vector<Bend> bends = bendsOf(model, X_HL, digit.nodes, axis);
  for (std::size_t i = 0; i + 1 < bends.size(); ++i) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(bends[i].node)];
    const Eigen::Vector3d joint = X_HL[static_cast<std::size_t>(node.link)].translation();
    const Eigen::Vector3d before =
        in_plane(joint - X_HL[static_cast<std::size_t>(bends[i + 1].node) + 1].translation());
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

/// Of all digits.
std::vector<AtZero> atZero(const HandModel& model,
                           const LinkPoses& X_SL,
                           const LinkPoses& X_HL,
                           const std::vector<Digit>& digits) {
  std::vector<AtZero> all;
  all.reserve(digits.size());
  for (const Digit& digit : digits)
    all.push_back(atZero(model, X_SL, X_HL, digit));
  return all;
}

LinkPoses posesAtZero(const HandModel& model) {
  LinkPoses X_HL;
  forwardKinematics(model, Pose::Identity(), model.zeroPose(), X_HL);
  return X_HL;
}

}  // namespace

void orientDigits(const HandModel& model, const LinkPoses& X_SL, std::vector<Digit>& digits) {
  const LinkPoses X_HL = posesAtZero(model);
  std::vector<std::size_t> unclear;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    Digit& digit = digits[i];
    const double clarity = orientFlexion(model, X_SL, digit);
    if (!digit.closing.isZero() && clarity < kClearAsymmetry) unclear.push_back(i);
    if (isShutAtZero(model, X_HL, digit, atZero(model, X_SL, X_HL, digit))) turnRound(digit);
  }
  orientUnclear(unclear, atZero(model, X_SL, X_HL, digits), digits);
  orientJaws(model, X_SL, digits);
}

void orientPair(const HandModel& model, const LinkPoses& X_SL, std::vector<Digit>& digits) {
  if (digits.size() != 2) return;
  const std::vector<AtZero> at_zero = atZero(model, X_SL, posesAtZero(model), digits);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d to_other = (at_zero[1 - i].tip - at_zero[i].tip).normalized();
    if (at_zero[i].closing.dot(to_other) < -kTowardsOthers) turnRound(digits[i]);
  }
}

}  // namespace handgraft::hand
