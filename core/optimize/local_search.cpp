#include "core/optimize/local_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "core/base/error.h"
#include "core/optimize/search_chart.h"

namespace handgraft::optimize {

namespace {

// Evaluations before the chart is laid anew about the best pose. MMA and CCSAQ crawl in a chart
// that no longer fits: 27 instead of 23 of the real problems within 1 % (DECISIONS).
constexpr int kFirstOrderRound = 40;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// rad; well before the rotation increment's chart folds at 2 pi.
constexpr double kLargestIncrement = 2.0;

// Share of the objective; a gain below it is not worth an evaluation.
constexpr double kWorthwhileGain = 1e-7;

// Share of the objective that a step promises at a pose called a minimum.
constexpr double kStationaryGain = 1e-5;

// Below it an objective counts as zero: points within 1e-8 m at the default weights.
constexpr double kSmallestObjective = 1e-12;

}  // namespace

PreparedProblem::PreparedProblem(const PoseProblem& source)
    : problem(source),
      tree(std::make_shared<const MomentTree>(makeMomentTree(source))),
      space(makeSearchSpace(source, *tree)) {}

LocalSearch::LocalSearch(const PreparedProblem& prepared)
    : problem_(prepared.problem),
      space_(prepared.space),
      objective_(problem_, prepared.tree),
      newton_(problem_, space_, objective_),
      gradient_(problem_.dofCount()) {}

void LocalSearch::attend(const Observer& observer, const std::function<void()>& keep_going) {
  observer_ = observer ? &observer : nullptr;
  keep_going_ = &keep_going;
}

LocalResult LocalSearch::begin(hand::HandPose start, int warm_up) {
  (*keep_going_)();
  start.X_WH.translation() =
      start.X_WH.translation().cwiseMax(problem_.root_lower).cwiseMin(problem_.root_upper);
  start.q = start.q.cwiseMax(problem_.lower).cwiseMin(problem_.upper);
  LocalResult result;
  result.terms = objective_.evaluate(start);
  result.pose = std::move(start);
  result.evaluations = 1;
  if (!std::isfinite(result.terms.objective)) {
    rejectInput(
        "problem: the objective at the start is {}; points, poses or weights are too "
        "large for floating point",
        result.terms.objective);
  }
  if (warm_up > 0 && problem_.normal_form != NormalForm::kSum) warmUp(warm_up, result);
  if (observer_ != nullptr) (*observer_)(result.pose, result.terms);
  return result;
}

void LocalSearch::advance(Solver solver, int evaluations, LocalResult& result) {
  if (space_.dofs.empty()) {
    result.outcome = Outcome::kConverged;
    return;
  }
  if (solver == Solver::kLm) {
    advanceByNewton(evaluations, result);
    return;
  }
  // The others build a model of the curvature over many steps, which a new chart would throw
  // away.
  const bool first_order = solver == Solver::kMma || solver == Solver::kCcsaq;
  const int round = first_order ? kFirstOrderRound : evaluations;
  const int budget = result.evaluations + evaluations;
  while (result.evaluations < budget) {
    const double before = result.terms.objective;
    const Stop stop = runOnce(solver, std::min(round, budget - result.evaluations), result);
    const double gain = before - result.terms.objective;
    if (stop != Stop::kAsked && gain <= kWorthwhileGain * before) break;
  }
  if (isStationary(result)) {
    result.outcome = Outcome::kConverged;
  } else if (result.evaluations >= budget) {
    result.outcome = Outcome::kEvaluationLimit;
  } else {
    result.outcome = Outcome::kStalled;
  }
}

void LocalSearch::warmUp(int evaluations, LocalResult& result) {
  objective_.setNormalForm(NormalForm::kSum);
  newton_.begin(result.pose);
  int left = evaluations - 1;  // one is for the terms at its end
  while (newton_.improve(left) == NewtonSearch::Step::kBetter)
    (*keep_going_)();
  objective_.setNormalForm(problem_.normal_form);
  result.pose = newton_.pose();
  result.evaluations += evaluations - left;
  result.terms = objective_.evaluate(result.pose);
}

void LocalSearch::advanceByNewton(int evaluations, LocalResult& result) {
  int left = evaluations;
  newton_.begin(result.pose, result.damping);
  auto step = NewtonSearch::Step::kNoEvaluations;
  do {
    (*keep_going_)();
    step = newton_.improve(left);
    if (step == NewtonSearch::Step::kBetter && observer_ != nullptr) {
      (*observer_)(newton_.pose(), newton_.terms());
    }
  } while (step == NewtonSearch::Step::kBetter);
  result.pose = newton_.pose();
  result.terms = newton_.terms();
  result.damping = newton_.damping();
  result.evaluations += evaluations - left;
  if (step == NewtonSearch::Step::kConverged) {
    result.outcome = Outcome::kConverged;
  } else if (step == NewtonSearch::Step::kNoEvaluations) {
    result.outcome = Outcome::kEvaluationLimit;
  } else {
    result.outcome = isStationary(result) ? Outcome::kConverged : Outcome::kStalled;
  }
}

Stop LocalSearch::runOnce(Solver solver, int evaluations, LocalResult& result) {
  // === The chart about the best pose
  // Locks hold coordinates of the rotation vector itself: then it has to be the variable.
  Eigen::Matrix3d base_R_W = result.pose.X_WH.linear();
  if (space_.rotation_partly_locked) base_R_W.setIdentity();
  Eigen::VectorXd theta(problem_.dofCount());
  theta << vectorFromRotation(result.pose.X_WH.linear() * base_R_W.transpose()),
      result.pose.X_WH.translation(), result.pose.q;
  const Eigen::VectorXd center = theta(space_.dofs);
  const SearchChart chart = makeSearchChart(
      center, objective_.gaussNewton(result.pose)(space_.dofs, space_.dofs), space_.lower,
      space_.upper, std::max(result.terms.objective, kSmallestObjective));
  const double value_scale = std::max(result.terms.objective, kSmallestObjective);

  BoxProblem box;
  box.max_evaluations = evaluations;
  box.start = Eigen::VectorXd::Zero(center.size());
  box.lower = chart.lower;
  box.upper = chart.upper;

  // === The function in its variables
  hand::HandPose pose = result.pose;
  Eigen::VectorXd free_theta = center;
  Eigen::VectorXd free_gradient = center;
  box.function = [&](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    (*keep_going_)();
    free_theta = center;
    free_theta.noalias() += chart.basis * x;
    free_theta = free_theta.cwiseMax(space_.lower).cwiseMin(space_.upper);
    theta(space_.dofs) = free_theta;
    const Eigen::Vector3d w = theta.head<3>();
    pose.X_WH.linear() = rotationFromVector(w) * base_R_W;
    pose.X_WH.translation() = theta.segment<3>(3);
    pose.q = theta.tail(pose.q.size());
    const Terms terms = objective_.evaluate(pose, gradient_);
    ++result.evaluations;

    gradient_.head<3>() = leftJacobian(w).transpose() * gradient_.head<3>().eval();
    free_gradient = gradient_(space_.dofs) / value_scale;
    gradient.noalias() = chart.basis.transpose() * free_gradient;
    Sample sample;
    sample.value = terms.objective / value_scale;
    if (terms.objective < result.terms.objective) {
      result.pose = pose;
      result.terms = terms;
      if (observer_ != nullptr) (*observer_)(result.pose, result.terms);
      sample.stop = !space_.rotation_partly_locked && w.norm() > kLargestIncrement;
    }
    return sample;
  };
  return minimizeInBox(solver, box);
}

bool LocalSearch::isStationary(const LocalResult& result) {
  objective_.evaluate(result.pose, gradient_);
  const Eigen::Vector3d w = vectorFromRotation(result.pose.X_WH.linear());
  if (space_.rotation_partly_locked) {
    gradient_.head<3>() = leftJacobian(w).transpose() * gradient_.head<3>().eval();
  }
  Eigen::VectorXd theta(problem_.dofCount());
  theta << w, result.pose.X_WH.translation(), result.pose.q;

  // Coordinates that a bound does not keep from going downhill.
  constexpr double kAtBound = 1e-9;  // rad or m
  std::vector<int> moving;
  for (std::size_t k = 0; k < space_.dofs.size(); ++k) {
    const int dof = space_.dofs[k];
    const auto entry = static_cast<Eigen::Index>(k);
    const bool held = (gradient_[dof] > 0.0 && theta[dof] <= space_.lower[entry] + kAtBound) ||
                      (gradient_[dof] < 0.0 && theta[dof] >= space_.upper[entry] - kAtBound);
    if (!held) moving.push_back(dof);
  }
  if (moving.empty()) return true;

  // What a damped Gauss-Newton step promises to gain: g^T H^-1 g / 2.
  Eigen::MatrixXd H = objective_.gaussNewton(result.pose)(moving, moving);
  const double floor = std::max(1e-9 * H.diagonal().maxCoeff(), 1e-12);
  H.diagonal() = H.diagonal().cwiseMax(floor) * (1.0 + 1e-6);
  const Eigen::VectorXd g = gradient_(moving);
  const double gain = 0.5 * g.dot(H.ldlt().solve(g));
  return gain <= std::max(kStationaryGain * result.terms.objective, kSmallestObjective);
}

}  // namespace handgraft::optimize
