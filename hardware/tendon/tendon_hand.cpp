#include "hardware/tendon/tendon_hand.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Dense>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/tendon/elastic_posture.h"

namespace handgraft::tendon {

namespace {

using Problems = std::vector<std::string>;

constexpr double kLeastArm = 1e-5;  // m/rad; a hundredth of a millimetre moves nothing

// === One thing at a time

void checkJoint(const TendonJoint& joint, bool is_elastic, Problems& problems) {
  const std::string name = "joint " + quoted(joint.name);
  if (!(joint.range.lower < joint.range.upper) || !std::isfinite(joint.range.lower) ||
      !std::isfinite(joint.range.upper)) {
    problems.push_back(fmt::format("{}: range [{}, {}] rad must be finite and not empty", name,
                                   joint.range.lower, joint.range.upper));
  }
  if (!(joint.stiffness >= 0) || !std::isfinite(joint.stiffness)) {
    problems.push_back(
        fmt::format("{}: stiffness {} Nm/rad is not in [0, inf)", name, joint.stiffness));
  } else if ((joint.stiffness > 0) != is_elastic) {
    problems.push_back(name + ": either all joints have a stiffness or none has");
  }
  if (!std::isfinite(joint.rest))
    problems.push_back(fmt::format("{}: rest {} rad is not finite", name, joint.rest));
}

void checkNumbers(const Tendon& tendon, bool is_elastic, Problems& problems) {
  const std::string name = "tendon " + quoted(tendon.name);
  if (!(tendon.spool.radius_m > 0) || !std::isfinite(tendon.spool.radius_m))
    problems.push_back(
        fmt::format("{}: spool radius {} m is not positive", name, tendon.spool.radius_m));
  if (!(tendon.spool.growth_m >= 0) || !std::isfinite(tendon.spool.growth_m))
    problems.push_back(
        fmt::format("{}: spool growth {} m is not in [0, inf)", name, tendon.spool.growth_m));
  if (!(tendon.stiffness > 0))
    problems.push_back(
        fmt::format("{}: stiffness {} N/m is not positive", name, tendon.stiffness));
  if (!is_elastic) return;
  if (!(tendon.largest_tension > 0) || !std::isfinite(tendon.largest_tension))
    problems.push_back(fmt::format("{}: largest tension {} N is not positive and finite", name,
                                   tendon.largest_tension));
  else if (!(tendon.pretension >= 0) || !(tendon.pretension < tendon.largest_tension))
    problems.push_back(fmt::format("{}: pretension {} N is not in [0, {})", name,
                                   tendon.pretension, tendon.largest_tension));
}

void checkCrossings(const TendonHand& hand, const Tendon& tendon, Problems& problems) {
  const std::string name = "tendon " + quoted(tendon.name);
  if (tendon.crossings.empty()) problems.push_back(name + " crosses no joint");
  std::set<std::size_t> seen;
  for (const Crossing& crossing : tendon.crossings) {
    if (crossing.joint >= hand.joints.size() || !seen.insert(crossing.joint).second) {
      problems.push_back(
          fmt::format("{}: joint {} does not exist or is crossed twice", name, crossing.joint));
      continue;
    }
    const TendonJoint& joint = hand.joints[crossing.joint];
    const Range slopes = crossing.extension.slopes(joint.range);
    if (!(slopes.lower >= kLeastArm) && !(slopes.upper <= -kLeastArm)) {
      problems.push_back(fmt::format(
          "{}: its arm at joint {} goes from {} to {} m; it must keep its sign and {} m", name,
          quoted(joint.name), slopes.lower, slopes.upper, kLeastArm));
    }
    if (!hand.isElastic() && !crossing.extension.isLinear())
      problems.push_back(name + ": without springs its arms must be constant");
  }
}

// === The whole

void checkNames(const TendonHand& hand, Problems& problems) {
  std::set<std::string> joints, tendons;
  for (const TendonJoint& joint : hand.joints) {
    if (joint.name.empty() || !joints.insert(joint.name).second)
      problems.push_back("joint name " + quoted(joint.name) + " is empty or twice");
  }
  for (const Tendon& tendon : hand.tendons) {
    if (tendon.name.empty() || !tendons.insert(tendon.name).second)
      problems.push_back("tendon name " + quoted(tendon.name) + " is empty or twice");
  }
}

void checkEveryJointIsMoved(const TendonHand& hand, Problems& problems) {
  std::set<std::size_t> moved;
  for (const Tendon& tendon : hand.tendons) {
    for (const Crossing& crossing : tendon.crossings)
      moved.insert(crossing.joint);
  }
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    if (moved.count(j) == 0)
      problems.push_back("joint " + quoted(hand.joints[j].name) + " is moved by no tendon");
  }
}

/// Pulled harder, an arm that grows with the angle must not outgrow the spring.
void checkStability(const TendonHand& hand, Problems& problems) {
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    double most = 0;
    for (const Tendon& tendon : hand.tendons) {
      for (const Crossing& crossing : tendon.crossings) {
        if (crossing.joint != j) continue;
        const double growth = crossing.extension.largestCurvature(hand.joints[j].range);
        most += tendon.largest_tension * std::max(0.0, growth);
      }
    }
    if (!(most < hand.joints[j].stiffness)) {
      problems.push_back(fmt::format(
          "joint {}: stiffness {} Nm/rad must exceed {} Nm/rad, by which arms grow at the "
          "largest tension",
          quoted(hand.joints[j].name), hand.joints[j].stiffness, most));
    }
  }
}

/// Where every tendon is pulled in as far as any pose asks, tensions must suffice.
void checkTensions(const TendonHand& hand, Problems& problems) {
  ElasticPosture posture(hand);
  std::vector<double> lowest, highest;
  for (const Tendon& tendon : hand.tendons) {
    lowest.push_back(tendon.pretension);
    highest.push_back(tendon.largest_tension);
  }
  for (std::size_t i = 0; i < hand.tendons.size(); ++i) {
    // The pose that pulls this tendon in farthest: its flexed joints up, the others at rest.
    std::vector<double> pose;
    for (const TendonJoint& joint : hand.joints)
      pose.push_back(std::clamp(joint.rest, joint.range.lower, joint.range.upper));
    for (const Crossing& crossing : hand.tendons[i].crossings) {
      const Range& range = hand.joints[crossing.joint].range;
      const bool flexes = crossing.extension.at(range.lower).slope > 0;
      pose[crossing.joint] = flexes ? range.upper : range.lower;
    }
    std::vector<double> e(hand.tendons.size());
    for (std::size_t k = 0; k < e.size(); ++k) {
      for (const Crossing& crossing : hand.tendons[k].crossings)
        e[k] += crossing.extension.at(pose[crossing.joint]).e;
    }
    const bool settles = posture.solve(e, lowest, highest, ElasticPosture::Stretch::kNone);
    const std::string name = "tendon " + quoted(hand.tendons[i].name);
    if (!settles) problems.push_back(name + ": the hand's posture is not determined");
    if (e[i] - posture.excursionOf(i) > 1e-6) {
      problems.push_back(fmt::format(
          "{}: {} N pull it in by {} m only, not by the {} m that the joints' ranges ask for",
          name, highest[i], posture.excursionOf(i), e[i]));
    }
  }
}

/// True if f >= 1 with R^T f = 0 exists: all tendons can be taut while no joint is loaded.
/// Projected coordinate descent on |R^T f|^2; R's columns are scaled to be of size one.
bool canAllBeTaut(const Eigen::MatrixXd& R) {
  Eigen::MatrixXd A = R.transpose();
  for (Eigen::Index j = 0; j < A.rows(); ++j)
    A.row(j) /= A.row(j).cwiseAbs().maxCoeff();
  Eigen::VectorXd f = Eigen::VectorXd::Ones(A.cols());
  Eigen::VectorXd rest = A * f;
  for (int sweep = 0; sweep < 2000 && rest.norm() > 1e-9 * f.norm(); ++sweep) {
    for (Eigen::Index i = 0; i < A.cols(); ++i) {
      const double better = std::max(1.0, f[i] - A.col(i).dot(rest) / A.col(i).squaredNorm());
      rest += A.col(i) * (better - f[i]);
      f[i] = better;
    }
  }
  return rest.norm() <= 1e-6 * f.norm();
}

void checkRigid(const TendonHand& hand, Problems& problems) {
  const auto n = static_cast<Eigen::Index>(hand.joints.size());
  const auto m = static_cast<Eigen::Index>(hand.tendons.size());
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(m, n);
  bool all_loops = true;
  for (Eigen::Index i = 0; i < m; ++i) {
    const Tendon& tendon = hand.tendons[static_cast<std::size_t>(i)];
    all_loops = all_loops && tendon.closed_loop;
    for (const Crossing& crossing : tendon.crossings)
      R(i, static_cast<Eigen::Index>(crossing.joint)) = crossing.extension.at(0).slope;
  }
  Eigen::FullPivLU<Eigen::MatrixXd> decomposed(R);
  decomposed.setThreshold(1e-6);
  if (decomposed.rank() < n) {
    problems.push_back(fmt::format(
        "{} tendons determine {} of {} joints; without springs they must determine all", m,
        decomposed.rank(), n));
    return;
  }
  // Loops may carry any tension, in both directions; the others only pull.
  if (!all_loops && !canAllBeTaut(R))
    problems.push_back(
        "tendons only pull and cannot all be taut at once: they need closed loops, springs, or "
        "one tendon more than joints, pulling against the others");
}

}  // namespace

std::vector<std::string> problemsOf(const TendonHand& hand) {
  Problems problems;
  if (hand.joints.empty()) problems.emplace_back("a tendon hand needs joints");
  if (hand.tendons.empty()) problems.emplace_back("a tendon hand needs tendons");
  checkNames(hand, problems);
  for (const TendonJoint& joint : hand.joints)
    checkJoint(joint, hand.isElastic(), problems);
  for (const Tendon& tendon : hand.tendons)
    checkNumbers(tendon, hand.isElastic(), problems);
  if (!problems.empty()) return problems;
  for (const Tendon& tendon : hand.tendons)
    checkCrossings(hand, tendon, problems);
  checkEveryJointIsMoved(hand, problems);
  if (!problems.empty()) return problems;
  if (hand.isElastic()) {
    checkStability(hand, problems);
    if (problems.empty()) checkTensions(hand, problems);
  } else {
    checkRigid(hand, problems);
  }
  for (const Tendon& tendon : hand.tendons) {
    double least = 0;
    for (const Crossing& crossing : tendon.crossings)
      least += crossing.extension.excursions(hand.joints[crossing.joint].range).lower;
    if (!(least > tendon.spool.leastExcursion() / 2))
      problems.push_back(
          fmt::format("tendon {}: must pay out {} m, more than half of the {} m to its core",
                      quoted(tendon.name), -least, -tendon.spool.leastExcursion()));
  }
  return problems;
}

}  // namespace handgraft::tendon
