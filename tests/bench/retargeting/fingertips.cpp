#include "tests/bench/retargeting/fingertips.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/hand/digits.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/solver.h"

namespace handgraft::bench {

namespace {

using Eigen::Vector3d;

constexpr double kJointWeight = 0.1;

/// The pad that somebody chose or that was found on the digit's last links.
std::optional<hand::ContactSite> padOf(const hand::Hand& hand, const hand::Digit& digit) {
  for (const hand::ContactSite& site : hand.sites) {
    const int link = hand.model->linkIndex(site.link);
    if (std::find(digit.tip_links.begin(), digit.tip_links.end(), link) !=
        digit.tip_links.end())
      return site;
  }
  return std::nullopt;
}

/// Fingers as they stand side by side; others of them by name.
std::vector<std::string> inOrder(std::vector<std::string> names) {
  std::erase(names, "thumb");
  const auto rank_of = [](const std::string& name) {
    constexpr std::array<const char*, 4> kOrder{"index", "middle", "ring", "little"};
    return std::find(kOrder.begin(), kOrder.end(), name) - kOrder.begin();
  };
  std::sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return std::pair(rank_of(a), a) < std::pair(rank_of(b), b);
  });
  return names;
}

void findPalm(const hand::Hand& hand,
              const hand::Digits& digits,
              const std::vector<std::string>& names,
              const hand::LinkPoses& X_SL,
              Fingertips& result) {
  std::vector<const hand::Digit*> fingers;
  for (const std::string& name : inOrder(names)) {
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    fingers.push_back(&digits.digits[static_cast<std::size_t>(at)]);
  }
  result.palm_link = digits.palm_link;
  if (fingers.size() < 2) return;
  Vector3d middle = Vector3d::Zero();
  Vector3d closing = Vector3d::Zero();
  for (const hand::Digit* finger : fingers) {
    middle += finger->base / static_cast<double>(fingers.size());
    closing += finger->closing;
  }
  for (const hand::ContactSite& site : hand.sites) {
    if (hand.model->linkIndex(site.link) != digits.palm_link) continue;
    closing = X_SL[static_cast<std::size_t>(digits.palm_link)].linear() * site.n_L;
  }
  const Vector3d across = (fingers.back()->base - fingers.front()->base).normalized();
  const Vector3d out = closing - closing.dot(across) * across;
  if (!(out.norm() > 1e-6)) return;
  Pose X_SP = Pose::Identity();
  X_SP.translation() = middle;
  X_SP.linear().col(1) = across;
  X_SP.linear().col(2) = out.normalized();
  X_SP.linear().col(0) = across.cross(out.normalized());
  result.X_LP = inverse(X_SL[static_cast<std::size_t>(digits.palm_link)]) * X_SP;
  result.has_palm = true;
}

}  // namespace

Fingertips fingertipsOf(const hand::Hand& hand) {
  const hand::LinkPoses X_SL =
      hand::forwardKinematics(*hand.model, {Pose::Identity(), hand.skin->qReference()});
  hand::Digits digits = hand::findDigits(*hand.model, X_SL);
  const std::vector<std::string> names = hand::nameDigits(digits.digits).names;
  Fingertips result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const hand::Digit& digit = digits.digits[i];
    Fingertips::Tip tip;
    tip.digit = names[i];
    tip.link = hand.model->nodes()[static_cast<std::size_t>(digit.nodes.back())].link;
    const Pose X_LS = inverse(X_SL[static_cast<std::size_t>(tip.link)]);
    tip.joint_L = X_LS * digit.last_joint;
    tip.p_L = X_LS * digit.tip;
    if (const auto pad = padOf(hand, digit)) {
      const int link = hand.model->linkIndex(pad->link);
      tip.p_L = X_LS * (X_SL[static_cast<std::size_t>(link)] * pad->p_L);
    }
    result.tips.push_back(tip);
  }
  findPalm(hand, digits, names, X_SL, result);
  return result;
}

FingertipPose posed(const hand::HandModel& model,
                    const Fingertips& fingertips,
                    const hand::HandPose& pose) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, pose);
  FingertipPose result;
  for (const Fingertips::Tip& tip : fingertips.tips) {
    const Pose& X = X_WL[static_cast<std::size_t>(tip.link)];
    result.tips.push_back({tip.digit, X * tip.p_L, X * tip.joint_L});
  }
  result.X_WP = X_WL[static_cast<std::size_t>(fingertips.palm_link)] * fingertips.X_LP;
  return result;
}

hand::HandPose fingertipKinematics(const hand::Hand& hand,
                                   const Fingertips& fingertips,
                                   const FingertipPose& human,
                                   const hand::HandPose* before) {
  optimize::PoseProblem problem = optimize::makeProblem(hand.model);
  problem.weights.normal = 0.0;
  problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
  problem.prior_weights.head<6>().setZero();
  int tips = 0;
  for (const Fingertips::Tip& tip : fingertips.tips) {
    for (const FingertipPose::Tip& target : human.tips) {
      if (target.digit != tip.digit) continue;
      optimize::PointPair pair;
      pair.link = tip.link;
      pair.n_L = Vector3d::UnitZ();
      pair.n_W = Vector3d::UnitZ();
      pair.p_L = tip.p_L;
      pair.p_W = target.p_W;
      problem.pairs.push_back(pair);
      pair.p_L = tip.joint_L;
      pair.p_W = target.joint_W;
      pair.weight = kJointWeight;
      problem.pairs.push_back(pair);
      ++tips;
    }
  }
  if (tips < 2) rejectInput("hand {} has fewer than two of the fingers", hand.model->name());
  optimize::SolveOptions solving;
  if (before != nullptr) {
    problem.start = *before;
    solving.starts = 1;
  }
  return optimize::solve(problem, solving, Progress()).pose;
}

}  // namespace handgraft::bench
