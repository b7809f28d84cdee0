#include "core/optimize/local_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// rad; well before the rotation increment's chart folds at 2 pi.
constexpr double kLargestIncrement = 2.0;

// Share of the objective; a gain below it is not worth an evaluation.
constexpr double kWorthwhileGain = 1e-7;

}  // namespace

/// Variables x <-> poses: theta_k = center_k + x_k / scale_k over the free degrees of freedom.
struct LocalSearch::Chart {
  Eigen::Matrix3d R_base;  ///< the rotation's increment is about this
  Eigen::VectorXd center;  ///< 6 + dofs: increment, position, joints
  Eigen::VectorXd scale;   ///< of the free ones
  double value_scale = 1.0;
};

LocalSearch::LocalSearch(const PoseProblem& problem,
                         const Observer& observer,
                         const std::function<void()>& keep_going)
    : problem_(problem), observer_(observer), keep_going_(keep_going), objective_(problem) {
  const int dofs = problem.dofCount();
  lower_.setConstant(dofs, -kInfinity);
  upper_.setConstant(dofs, kInfinity);
  lower_.segment<3>(3) = problem.root_lower;
  upper_.segment<3>(3) = problem.root_upper;
  lower_.tail(dofs - 6) = problem.lower;
  upper_.tail(dofs - 6) = problem.upper;
  for (int i = 0; i < dofs; ++i) {
    const bool locked = !problem.locked.empty() && problem.locked[static_cast<std::size_t>(i)];
    if (!locked && lower_[i] < upper_[i]) free_dofs_.push_back(i);
  }
  const auto free_rotations = std::count_if(free_dofs_.begin(), free_dofs_.end(), [](int dof) {
    return dof < 3;
  });
  rotation_partly_locked_ = free_rotations == 1 || free_rotations == 2;
  gradient_.resize(dofs);
}

LocalResult LocalSearch::begin(hand::HandPose start) {
  keep_going_();
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
  if (observer_) observer_(result.pose, result.terms);
  return result;
}

void LocalSearch::advance(Solver solver, int evaluations, LocalResult& result) {
  if (free_dofs_.empty()) {
    result.outcome = Outcome::kConverged;
    return;
  }
  const int budget = result.evaluations + evaluations;
  Stop stop = Stop::kEvaluations;
  while (result.evaluations < budget) {
    const double before = result.terms.objective;
    stop = runOnce(solver, budget - result.evaluations, result);
    // A fresh start about the best pose often goes on where a solver's model had worn out.
    const double gain = before - result.terms.objective;
    if (stop != Stop::kAsked && gain <= kWorthwhileGain * std::abs(before)) break;
  }
  if (isStationary(result)) {
    result.outcome = Outcome::kConverged;
  } else if (result.evaluations >= budget) {
    result.outcome = Outcome::kEvaluationLimit;
  } else {
    result.outcome = Outcome::kStalled;
  }
}

Stop LocalSearch::runOnce(Solver solver, int evaluations, LocalResult& result) {
  const auto count = static_cast<Eigen::Index>(free_dofs_.size());

  // === The chart about the best pose
  Chart chart;
  chart.center.resize(problem_.dofCount());
  if (rotation_partly_locked_) {
    // Locks hold coordinates of the rotation vector itself, so it has to be the variable.
    chart.R_base = Eigen::Matrix3d::Identity();
    chart.center.head<3>() = vectorFromRotation(result.pose.X_WH.linear());
  } else {
    chart.R_base = result.pose.X_WH.linear();
    chart.center.head<3>().setZero();
  }
  chart.center.segment<3>(3) = result.pose.X_WH.translation();
  chart.center.tail(problem_.model->dofCount()) = result.pose.q;
  chart.value_scale = std::max(result.terms.objective, 1e-12);
  const Eigen::VectorXd stiffness = objective_.stiffness(result.pose);
  const double floor = std::max(1e-9 * stiffness.maxCoeff(), 1e-12);
  chart.scale.resize(count);

  BoxProblem box;
  box.max_evaluations = evaluations;
  box.start = Eigen::VectorXd::Zero(count);
  box.lower.resize(count);
  box.upper.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const int dof = free_dofs_[static_cast<std::size_t>(k)];
    chart.scale[k] = std::sqrt(std::max(stiffness[dof], floor) / chart.value_scale);
    box.lower[k] = std::min(0.0, (lower_[dof] - chart.center[dof]) * chart.scale[k]);
    box.upper[k] = std::max(0.0, (upper_[dof] - chart.center[dof]) * chart.scale[k]);
  }

  // === The function in its variables
  hand::HandPose pose = result.pose;
  Eigen::VectorXd theta = chart.center;
  box.function = [&](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    keep_going_();
    for (Eigen::Index k = 0; k < count; ++k) {
      const int dof = free_dofs_[static_cast<std::size_t>(k)];
      theta[dof] =
          std::clamp(chart.center[dof] + x[k] / chart.scale[k], lower_[dof], upper_[dof]);
    }
    const Eigen::Vector3d w = theta.head<3>();
    pose.X_WH.linear() = rotationFromVector(w) * chart.R_base;
    pose.X_WH.translation() = theta.segment<3>(3);
    pose.q = theta.tail(pose.q.size());
    const Terms terms = objective_.evaluate(pose, gradient_);
    ++result.evaluations;

    gradient_.head<3>() = leftJacobian(w).transpose() * gradient_.head<3>().eval();
    for (Eigen::Index k = 0; k < count; ++k) {
      gradient[k] = gradient_[free_dofs_[static_cast<std::size_t>(k)]] /
                    (chart.scale[k] * chart.value_scale);
    }
    Sample sample;
    sample.value = terms.objective / chart.value_scale;
    if (terms.objective < result.terms.objective) {
      result.pose = pose;
      result.terms = terms;
      if (observer_) observer_(result.pose, result.terms);
      sample.stop = !rotation_partly_locked_ && w.norm() > kLargestIncrement;
    }
    return sample;
  };
  return minimizeInBox(solver, box);
}

bool LocalSearch::isStationary(const LocalResult& result) {
  objective_.evaluate(result.pose, gradient_);
  if (rotation_partly_locked_) {
    const Eigen::Vector3d w = vectorFromRotation(result.pose.X_WH.linear());
    gradient_.head<3>() = leftJacobian(w).transpose() * gradient_.head<3>().eval();
  }
  const Eigen::VectorXd stiffness = objective_.stiffness(result.pose);
  const double floor = std::max(1e-9 * stiffness.maxCoeff(), 1e-12);
  double gain = 0.0;
  for (const int dof : free_dofs_) {
    double value = 0.0;  // the rotation has no bounds to stand at
    if (dof >= 6) {
      value = result.pose.q[dof - 6];
    } else if (dof >= 3) {
      value = result.pose.X_WH.translation()[dof - 3];
    }
    // A bound in the way of the descent takes its gain away.
    if (gradient_[dof] > 0.0 && value <= lower_[dof] + 1e-9) continue;
    if (gradient_[dof] < 0.0 && value >= upper_[dof] - 1e-9) continue;
    gain += 0.5 * gradient_[dof] * gradient_[dof] / std::max(stiffness[dof], floor);
  }
  constexpr double kStationary = 1e-5;  // share of the objective that a Newton step would gain
  return gain <= std::max(kStationary * result.terms.objective, 1e-12);
}

}  // namespace handgraft::optimize
