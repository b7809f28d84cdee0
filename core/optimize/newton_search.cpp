#include "core/optimize/newton_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

// Share of the promised gain that a step has to keep.
constexpr double kLeastRatio = 1e-4;

constexpr double kLeastDamping = 1e-12;
constexpr double kMostDamping = 1e12;

// Below it damping no longer shortens a step that matters.
constexpr double kUndamped = 1e-6;

// Below it an objective counts as zero: points within 1e-8 m at the default weights.
constexpr double kSmallestObjective = 1e-12;

double cube(double x) {
  return x * x * x;
}

}  // namespace

NewtonSearch::NewtonSearch(const PoseProblem& problem,
                           const SearchSpace& space,
                           Objective& objective)
    : space_(space),
      objective_(objective),
      pose_(problem.start),
      trial_(problem.start),
      model_(problem.dofCount()),
      factor_(static_cast<int>(space.dofs.size())),
      size_(static_cast<int>(space.dofs.size())) {
  const auto count = space.dofs.size();
  for (Eigen::VectorXd* vector :
       {&gradient_, &scale_, &lower_gap_, &upper_gap_, &step_, &solution_}) {
    *vector = Eigen::VectorXd::Zero(size_);
  }
  gauss_newton_ = exact_ = Eigen::MatrixXd::Zero(size_, size_);
  held_.assign(count, 0);
  moving_.reserve(count);
  first_.reserve(count);
  rank_.assign(count, 0);
}

void NewtonSearch::begin(const hand::HandPose& pose, double damping) {
  HANDGRAFT_REQUIRE(pose.q.size() == pose_.q.size());
  pose_ = pose;
  terms_ = objective_.evaluate(pose_);
  damping_ = damping > 0.0 ? damping : settings.first_damping;
  growth_ = 2.0;
  expanded_ = false;
}

NewtonSearch::Step NewtonSearch::improve(int& evaluations) {
  if (size_ == 0) return Step::kConverged;
  if (!expanded_) expand();
  const double worthwhile =
      std::max(settings.promise * terms_.objective, settings.promise * kSmallestObjective);
  bool tried_undamped = damping_ <= kUndamped;
  while (evaluations > 0) {
    const double promise = propose();
    if (!(promise > worthwhile)) {
      if (tried_undamped) return Step::kConverged;
      // The damping may be what keeps it from promising more.
      tried_undamped = true;
      damping_ = kUndamped;
      continue;
    }
    moveTo(trial_);
    const Terms terms = objective_.evaluate(trial_);
    --evaluations;
    const double ratio = (terms_.objective - terms.objective) / promise;
    if (ratio > kLeastRatio) {
      std::swap(pose_, trial_);
      terms_ = terms;
      const double shrink = 1.0 - cube(2.0 * ratio - 1.0);
      damping_ = std::max(kLeastDamping, damping_ * std::max(1.0 / 3.0, shrink));
      growth_ = 2.0;
      expanded_ = false;
      return Step::kBetter;
    }
    damping_ *= growth_;
    growth_ *= 2.0;
    if (damping_ > kMostDamping) return Step::kStuck;
  }
  return Step::kNoEvaluations;
}

void NewtonSearch::expand() {
  objective_.expand(model_);
  expanded_ = true;
  if (space_.rotation_partly_locked) {
    // The variables are the rotation vector's coordinates, not an increment.
    const Eigen::Matrix3d J = leftJacobian(vectorFromRotation(pose_.X_WH.linear()));
    auto& H = model_.gauss_newton;
    model_.gradient.head<3>() = J.transpose() * model_.gradient.head<3>().eval();
    for (Eigen::Index i = 0; i < H.cols(); ++i)
      H.col(i).head<3>() = J.transpose() * H.col(i).head<3>().eval();
    for (Eigen::Index i = 0; i < H.rows(); ++i)
      H.row(i).head<3>() = H.row(i).head<3>().eval() * J;
  }
  const double floor = std::max(1e-9 * model_.gauss_newton.diagonal().maxCoeff(), 1e-12);
  for (int i = 0; i < size_; ++i) {
    const int dof = space_.dofs[static_cast<std::size_t>(i)];
    gradient_[i] = model_.gradient[dof];
    for (int j = space_.first[static_cast<std::size_t>(i)]; j <= i; ++j) {
      const int other = space_.dofs[static_cast<std::size_t>(j)];
      gauss_newton_(j, i) = model_.gauss_newton(other, dof);
      exact_(j, i) = gauss_newton_(j, i) + model_.residual_curvature(other, dof);
    }
    scale_[i] = std::max(model_.gauss_newton(dof, dof), floor);
    if (dof < 3) {
      lower_gap_[i] = space_.lower[i];
      upper_gap_[i] = space_.upper[i];
      continue;
    }
    const double value = dof < 6 ? pose_.X_WH.translation()[dof - 3] : pose_.q[dof - 6];
    lower_gap_[i] = space_.lower[i] - value;
    upper_gap_[i] = space_.upper[i] - value;
  }
}

double NewtonSearch::propose() {
  bool exact = settings.exact && !space_.rotation_partly_locked;
  if (exact && !proposeBy(true)) exact = false;
  if (!exact) {
    while (!proposeBy(false) && damping_ < kMostDamping)
      damping_ = std::max(10.0 * damping_, kUndamped);
  }
  // A turn too long leaves the region where any model holds.
  double longest = 0.0;
  for (int i = 0; i < size_; ++i) {
    const int dof = space_.dofs[static_cast<std::size_t>(i)];
    if (dof >= 3 && dof < 6) continue;
    longest = std::max(longest, std::abs(step_[i]));
  }
  const double share = std::min(1.0, settings.longest_turn / std::max(longest, 1e-300));
  const double promise = promiseOf(exact, share);
  if (share < 1.0) step_ *= share;
  return promise;
}

bool NewtonSearch::proposeBy(bool exact) {
  step_.setZero();
  for (int i = 0; i < size_; ++i) {
    held_[static_cast<std::size_t>(i)] =
        static_cast<char>((lower_gap_[i] >= 0.0 && gradient_[i] > 0.0) ||
                          (upper_gap_[i] <= 0.0 && gradient_[i] < 0.0));
  }
  do {
    if (!solveMoving(exact)) return false;
  } while (holdLeavers());
  return true;
}

bool NewtonSearch::solveMoving(bool exact) {
  moving_.clear();
  first_.clear();
  for (int i = 0; i < size_; ++i) {
    const auto index = static_cast<std::size_t>(i);
    rank_[index] = static_cast<int>(moving_.size());
    if (held_[index] != 0) continue;
    first_.push_back(rank_[static_cast<std::size_t>(space_.first[index])]);
    moving_.push_back(i);
  }
  const int count = static_cast<int>(moving_.size());
  const bool positive = factor_.factor(count, first_, [&](int a, int b) {
    const int i = moving_[static_cast<std::size_t>(a)];
    if (a != b) return hessian(i, moving_[static_cast<std::size_t>(b)], exact);
    return hessian(i, i, exact) + damping_ * scale_[i];
  });
  if (!positive) return false;

  for (int a = 0; a < count; ++a)
    solution_[a] = -gradient_[moving_[static_cast<std::size_t>(a)]];
  for (int j = 0; j < size_; ++j) {
    if (held_[static_cast<std::size_t>(j)] == 0 || step_[j] == 0.0) continue;
    for (int a = 0; a < count; ++a)
      solution_[a] -= hessian(moving_[static_cast<std::size_t>(a)], j, exact) * step_[j];
  }
  factor_.solve(solution_.data());
  for (int a = 0; a < count; ++a)
    step_[moving_[static_cast<std::size_t>(a)]] = solution_[a];
  return true;
}

bool NewtonSearch::holdLeavers() {
  bool any = false;
  for (const int i : moving_) {
    const double inside =
        std::clamp(step_[i], std::min(lower_gap_[i], 0.0), std::max(upper_gap_[i], 0.0));
    if (inside == step_[i]) continue;
    step_[i] = inside;
    held_[static_cast<std::size_t>(i)] = 1;
    any = true;
  }
  return any;
}

double NewtonSearch::promiseOf(bool exact, double share) const {
  // The rows that move say what H s is: (H + damping) s = -gradient.
  double slope = 0.0;
  double curvature = 0.0;
  for (int i = 0; i < size_; ++i) {
    if (step_[i] == 0.0) continue;
    slope += gradient_[i] * step_[i];
    double row = -gradient_[i] - damping_ * scale_[i] * step_[i];
    if (held_[static_cast<std::size_t>(i)] != 0) {
      row = 0.0;
      for (int j = 0; j < size_; ++j)
        row += hessian(i, j, exact) * step_[j];
    }
    curvature += row * step_[i];
  }
  return -share * (slope + 0.5 * share * curvature);
}

void NewtonSearch::moveTo(hand::HandPose& pose) const {
  pose = pose_;
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  for (int i = 0; i < size_; ++i) {
    const int dof = space_.dofs[static_cast<std::size_t>(i)];
    if (dof < 3) {
      w[dof] = step_[i];
      continue;
    }
    double& value = dof < 6 ? pose.X_WH.translation()[dof - 3] : pose.q[dof - 6];
    // Onto the border exactly, whatever rounding says.
    value = std::clamp(value + step_[i], space_.lower[i], space_.upper[i]);
  }
  if (space_.rotation_partly_locked) {
    pose.X_WH.linear() = rotationFromVector(vectorFromRotation(pose_.X_WH.linear()) + w);
  } else {
    pose.X_WH.linear() = rotationFromVector(w) * pose_.X_WH.linear();
  }
}

}  // namespace handgraft::optimize
