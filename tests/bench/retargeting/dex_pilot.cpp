#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include <nlopt.h>

#include "core/base/error.h"

#include "tests/bench/retargeting/fingertips.h"

namespace handgraft::bench {

namespace {

using Eigen::Vector3d;

// The paper's figures.
constexpr double kClose = 0.05;          // m; below it tips are to meet
constexpr double kThumbGap = 1e-4;       // m; between thumb and finger then
constexpr double kFingerGap = 0.03;      // m; between fingers then
constexpr double kThumbWeight = 200.0;   // then
constexpr double kFingerWeight = 400.0;  // then
constexpr double kRegularisation = 2.5e-3;

constexpr int kStarts = 4;
constexpr int kMostEvaluations = 300;   // a start
constexpr double kUnlimited = 3.14159;  // rad; of joints without limits

/// One vector of the objective: from a tip, or the palm (-1), to a tip.
struct Span {
  int from = -1;
  int to = 0;
  Vector3d target_P = Vector3d::Zero();
  double weight = 1.0;
};

struct Problem {
  const hand::HandModel& model;
  std::vector<Fingertips::Tip> tips;
  int palm_link = 0;
  Pose X_LP = Pose::Identity();
  std::vector<Span> spans;

  double value(const Eigen::VectorXd& q, double* slope) const {
    hand::LinkPoses X_HL;
    hand::forwardKinematics(model, Pose::Identity(), q, X_HL);
    const Pose X_HP = X_HL[static_cast<std::size_t>(palm_link)] * X_LP;
    std::vector<Vector3d> p_H;
    std::vector<Eigen::Matrix3Xd> J_H;
    for (const Fingertips::Tip& tip : tips) {
      p_H.push_back(X_HL[static_cast<std::size_t>(tip.link)] * tip.p_L);
      if (slope != nullptr)
        J_H.push_back(hand::pointJacobian(model, X_HL, tip.link, p_H.back()).bottomRows<3>());
    }
    Eigen::VectorXd gradient = 2.0 * kRegularisation * q;
    double sum = kRegularisation * q.squaredNorm();
    for (const Span& span : spans) {
      const auto to = static_cast<std::size_t>(span.to);
      const auto from = static_cast<std::size_t>(span.from);
      const Vector3d start_H = span.from < 0 ? X_HP.translation() : p_H[from];
      const Vector3d miss_H = p_H[to] - start_H - X_HP.linear() * span.target_P;
      sum += 0.5 * span.weight * miss_H.squaredNorm();
      if (slope == nullptr) continue;
      gradient += span.weight * J_H[to].transpose() * miss_H;
      if (span.from >= 0) gradient -= span.weight * J_H[from].transpose() * miss_H;
    }
    if (slope == nullptr) return sum;
    // Joints that carry the palm move all of it alike.
    const Eigen::MatrixXd palm_jacobian =
        hand::pointJacobian(model, X_HL, palm_link, X_HP.translation());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const bool carries = palm_jacobian.col(i).norm() > 0.0;
      slope[i] = carries ? 2.0 * kRegularisation * q[i] : gradient[i];
    }
    return sum;
  }

  static double sample(unsigned count, const double* x, double* slope, void* data) {
    return static_cast<const Problem*>(data)->value(
        Eigen::Map<const Eigen::VectorXd>(x, static_cast<Eigen::Index>(count)), slope);
  }
};

Problem problemOf(const hand::Hand& hand,
                  const Fingertips& fingertips,
                  const FingertipPose& human,
                  std::vector<Vector3d>& targets_W) {
  Problem problem{*hand.model, {}, fingertips.palm_link, fingertips.X_LP, {}};
  std::vector<Vector3d> target_P;
  for (const Fingertips::Tip& tip : fingertips.tips) {
    for (const FingertipPose::Tip& target : human.tips) {
      if (target.digit != tip.digit) continue;
      problem.tips.push_back(tip);
      targets_W.push_back(target.p_W);
      target_P.push_back(inverse(human.X_WP) * target.p_W);
    }
  }
  const auto count = static_cast<int>(problem.tips.size());
  for (int i = 0; i < count; ++i) {
    const auto a = static_cast<std::size_t>(i);
    problem.spans.push_back({-1, i, target_P[a], 1.0});
    for (int j = i + 1; j < count; ++j) {
      const auto b = static_cast<std::size_t>(j);
      const bool of_thumb =
          problem.tips[a].digit == "thumb" || problem.tips[b].digit == "thumb";
      Span span{i, j, target_P[b] - target_P[a], 1.0};
      const double length = span.target_P.norm();
      if (length <= kClose && length > 0.0) {
        span.weight = of_thumb ? kThumbWeight : kFingerWeight;
        span.target_P *= (of_thumb ? kThumbGap : kFingerGap) / length;
      }
      problem.spans.push_back(span);
    }
  }
  return problem;
}

/// SLSQP from one start; the objective there.
double descend(const Problem& problem,
               const Eigen::VectorXd& lower,
               const Eigen::VectorXd& upper,
               Eigen::VectorXd& q) {
  nlopt_opt optimiser = nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(q.size()));
  nlopt_set_lower_bounds(optimiser, lower.data());
  nlopt_set_upper_bounds(optimiser, upper.data());
  nlopt_set_maxeval(optimiser, kMostEvaluations);
  nlopt_set_ftol_rel(optimiser, 1e-6);
  // NLopt takes the data back as it was given; nothing writes there.
  nlopt_set_min_objective(optimiser, &Problem::sample, const_cast<Problem*>(&problem));
  double value = 0.0;
  nlopt_optimize(optimiser, q.data(), &value);  // whatever ends it, q is the best so far
  nlopt_destroy(optimiser);
  return problem.value(q, nullptr);
}

}  // namespace

hand::HandPose dexPilot(const hand::Hand& hand,
                        const Fingertips& fingertips,
                        const FingertipPose& human,
                        const hand::HandPose* before) {
  std::vector<Vector3d> targets_W;
  const Problem problem = problemOf(hand, fingertips, human, targets_W);
  if (problem.tips.size() < 2 || !fingertips.has_palm)
    rejectInput("hand {} has fewer than two of the fingers", hand.model->name());
  const Eigen::VectorXd lower = hand.model->lower().cwiseMax(-kUnlimited);
  const Eigen::VectorXd upper = hand.model->upper().cwiseMin(kUnlimited);
  std::mt19937 random(0);
  hand::HandPose best;
  double least = 0.0;
  for (int start = 0; start < (before == nullptr ? kStarts : 1); ++start) {
    Eigen::VectorXd q = before == nullptr ? hand.model->restPose() : before->q;
    q = q.cwiseMax(lower).cwiseMin(upper);
    for (Eigen::Index i = 0; start > 0 && i < q.size(); ++i) {
      const double share = static_cast<double>(random()) / 4294967295.0;
      q[i] = lower[i] + (start == 1 ? 0.5 : share) * (upper[i] - lower[i]);
    }
    const double value = descend(problem, lower, upper, q);
    if (start > 0 && !(value < least)) continue;
    least = value;
    best.q = q.cwiseMax(lower).cwiseMin(upper);
  }
  // The root: where tips and palm fit best.
  hand::LinkPoses X_HL;
  hand::forwardKinematics(*hand.model, Pose::Identity(), best.q, X_HL);
  const auto count = static_cast<Eigen::Index>(targets_W.size());
  Eigen::Matrix3Xd from(3, count + 1);
  Eigen::Matrix3Xd to(3, count + 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Fingertips::Tip& tip = problem.tips[static_cast<std::size_t>(i)];
    from.col(i) = X_HL[static_cast<std::size_t>(tip.link)] * tip.p_L;
    to.col(i) = targets_W[static_cast<std::size_t>(i)];
  }
  const auto palm = static_cast<std::size_t>(fingertips.palm_link);
  from.col(count) = X_HL[palm] * fingertips.X_LP.translation();
  to.col(count) = human.X_WP.translation();
  best.X_WH = Pose(Eigen::umeyama(from, to, false));
  return best;
}

}  // namespace handgraft::bench
