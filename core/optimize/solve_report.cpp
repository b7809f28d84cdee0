#include "core/optimize/solve_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/angle.h"
#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

template <typename IsLocked>
std::vector<ActiveLimit> limitsMet(const Eigen::VectorXd& lower,
                                   const Eigen::VectorXd& upper,
                                   const Eigen::VectorXd& q,
                                   const IsLocked& is_locked) {
  constexpr double kAtLimit = 1e-6;  // rad or m; below what a motor or a reader can tell
  HANDGRAFT_REQUIRE(q.size() == lower.size() && q.size() == upper.size());
  std::vector<ActiveLimit> limits;
  for (int j = 0; j < static_cast<int>(q.size()); ++j) {
    if (is_locked(j)) continue;
    if (q[j] <= lower[j] + kAtLimit) {
      limits.push_back({j, false});
    } else if (q[j] >= upper[j] - kAtLimit) {
      limits.push_back({j, true});
    }
  }
  return limits;
}

}  // namespace

std::string_view nameOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::kConverged:
      return "converged";
    case Outcome::kStalled:
      return "stalled";
    case Outcome::kEvaluationLimit:
      return "evaluation_limit";
    case Outcome::kInfeasible:
      return "infeasible";
  }
  HANDGRAFT_REQUIRE(false && "an outcome of the list");
  return {};
}

std::vector<PatchFit> fitPatches(const PoseProblem& problem, const hand::HandPose& pose) {
  validate(problem);
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, pose);
  std::map<int, PatchFit> fits;
  for (const PointPair& pair : problem.pairs) {
    if (pair.patch < 0) continue;
    const Pose& X = X_WL[static_cast<std::size_t>(pair.link)];
    const double distance_mm = 1e3 * (X * pair.p_L - pair.p_W).norm();
    const double angle_deg = inDegrees(angleBetween(X.linear() * pair.n_L, -pair.n_W));
    PatchFit& fit = fits[pair.patch];
    fit.patch = pair.patch;
    ++fit.point_count;
    fit.mean_mm += distance_mm;
    fit.rms_mm += distance_mm * distance_mm;
    fit.max_mm = std::max(fit.max_mm, distance_mm);
    fit.normal_mean_deg += angle_deg;
    if (distance_mm <= 2.0) fit.within_2mm += 1.0;
    if (distance_mm <= 5.0) fit.within_5mm += 1.0;
  }
  std::vector<PatchFit> result;
  result.reserve(fits.size());
  for (auto& [patch, fit] : fits) {
    const double count = fit.point_count;
    fit.mean_mm /= count;
    fit.rms_mm = std::sqrt(fit.rms_mm / count);
    fit.normal_mean_deg /= count;
    fit.within_2mm /= count;
    fit.within_5mm /= count;
    result.push_back(fit);
  }
  return result;
}

Terms sumOverPoints(const PoseProblem& problem, const hand::HandPose& pose) {
  PoseProblem bare = problem;
  bare.pairs.clear();
  return sumOverPoints(problem, pose, Objective(bare).evaluate(pose));
}

Terms sumOverPoints(const PoseProblem& problem, const hand::HandPose& pose, Terms terms) {
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, pose);
  terms.distance = 0.0;
  terms.normal = 0.0;
  for (const PointPair& pair : problem.pairs) {
    const Pose& X = X_WL[static_cast<std::size_t>(pair.link)];
    const Eigen::Vector3d n_W = X.linear() * pair.n_L;
    terms.distance += pair.weight * (X * pair.p_L - pair.p_W).squaredNorm();
    if (!pair.has_normals) continue;
    if (problem.normal_form == NormalForm::kSum) {
      terms.normal += pair.weight * (n_W + pair.n_W).squaredNorm();
    } else {
      const double miss = 1.0 + n_W.dot(pair.n_W);
      terms.normal += pair.weight * miss * miss;
    }
  }
  terms.objective = problem.weights.distance * terms.distance +
                    problem.weights.normal * terms.normal + problem.weights.prior * terms.prior;
  if (problem.avoidance != nullptr)
    terms.objective += problem.avoidance->weight * terms.penetration;
  return terms;
}

std::vector<ActiveLimit> activeLimits(const PoseProblem& problem, const hand::HandPose& pose) {
  return limitsMet(problem.lower, problem.upper, pose.q, [&problem](int j) {
    return !problem.locked.empty() && problem.locked[6 + static_cast<std::size_t>(j)];
  });
}

std::vector<ActiveLimit> activeLimits(const Eigen::VectorXd& lower,
                                      const Eigen::VectorXd& upper,
                                      const Eigen::VectorXd& q) {
  return limitsMet(lower, upper, q, [&](int j) {
    return lower[j] == upper[j];
  });
}

}  // namespace handgraft::optimize
