#include "core/manipulation/band_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace handgraft::manipulation {

namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-2;
constexpr double kLeastDamping = 1e-6;
constexpr double kMostDamping = 1e9;
constexpr double kWorthwhile = 1e-5;  // share of the objective that a step has to promise
// Of the stiffest frame's diagonal: frames without contacts are damped by that share of it.
constexpr double kLeastScale = 1e-2;
constexpr double kLeastRatio = 1e-4;
constexpr double kRaised = 10.0;         // the damping of a frame whose model was wrong
constexpr double kShortestShare = 0.01;  // of a step

}  // namespace

void BandSearch::descend(const SearchStage& stage, const Progress& progress, int& evaluations) {
  beginStage(stage, evaluations);
  bool expanded = false;
  for (int step = 0; step < stage.steps; ++step) {
    progress.checkpoint();
    if (!expanded) expand();
    expanded = true;
    const double promise = propose();
    if (!(promise > kWorthwhile * value_)) return;
    moveTrial();
    evaluations += static_cast<int>(poses_.size());
    double value = objective_.evaluateToExpand(trial_);
    bool better = value_ - value > kLeastRatio * promise;
    const bool any = judgeFrames(better);
    // Else what joins frames bends: limits that the whole step would break.
    if (!better && !any) better = shorten(promise, value, evaluations);
    if (better) {
      const bool is_enough = value_ - value < stage.enough * value_;
      std::swap(poses_, trial_);
      value_ = value;
      frames_ = objective_.frames();
      expanded = is_modelled_ = false;
      if (is_enough) return;
    } else if (!any) {
      raiseDamping();
    }
  }
}

void BandSearch::beginStage(const SearchStage& stage, int& evaluations) {
  objective_.join(stage.smoothness, stage.limits);
  if (level_ && *level_ == stage.level) {
    // Each frame alone costs what it did.
    value_ = objective_.joining(poses_);
    for (const double frame : frames_)
      value_ += frame;
  } else {
    objective_.level(stage.level);
    level_ = stage.level;
    value_ = objective_.evaluateToExpand(poses_);
    evaluations += static_cast<int>(poses_.size());
    frames_ = objective_.frames();
    is_modelled_ = false;
  }
  std::fill(damping_.begin(), damping_.end(), kFirstDamping);
}

bool BandSearch::shorten(double promise, double& value, int& evaluations) {
  for (double share = 1.0; share > kShortestShare;) {
    share *= 0.3;
    for (VectorXd& part : steps_)
      part *= 0.3;
    moveTrial();
    evaluations += static_cast<int>(poses_.size());
    value = objective_.evaluate(trial_);
    if (value_ - value > kLeastRatio * share * promise) {
      value = objective_.evaluateToExpand(trial_);
      return true;
    }
  }
  return false;
}

void BandSearch::raiseDamping() {
  for (double& damping : damping_)
    damping = std::min(kMostDamping, 10.0 * damping);
}

void BandSearch::moveTrial() {
  moveBy(problem_, of_, steps_, poses_, trial_);
  const std::size_t frames = poses_.size();
  for (std::size_t k = 0; k < frames; ++k)
    if (isHeld(k)) trial_[k] = poses_[k];
}

bool BandSearch::isHeld(std::size_t k) const {
  return k < held_.before || k + held_.behind >= poses_.size();
}

void BandSearch::expand() {
  if (!is_modelled_) objective_.takeModels();
  is_modelled_ = true;
  objective_.expand(poses_, undamped_);
  const std::size_t frames = poses_.size();
  for (std::size_t k = 0; k < frames; ++k) {
    if (k + 1 < frames && (isHeld(k) || isHeld(k + 1))) undamped_.next[k].reset();
    if (k + 2 < frames && (isHeld(k) || isHeld(k + 2))) undamped_.after_next[k].reset();
    if (!isHeld(k)) continue;
    undamped_.own[k].setIdentity();
    undamped_.right[k].setZero();
  }
  stiffest_ = VectorXd::Zero(objective_.dofCount());
  for (const MotionObjective::FrameModel& model : objective_.models())
    stiffest_ = stiffest_.cwiseMax(model.scale);
}

double BandSearch::propose() {
  constexpr int kPasses = 4;
  system_ = undamped_;
  for (std::size_t k = 0; k < poses_.size(); ++k)
    system_.own[k].diagonal() += dampingOf(k);
  std::vector<VectorXd> border(poses_.size(), VectorXd::Constant(objective_.dofCount(), kFree));
  holdAtLimits(border);
  for (int pass = 0; pass < kPasses; ++pass) {
    if (!cholesky_.solve(system_, steps_)) {
      raiseDamping();
      return propose();
    }
    if (!holdWhatLeaves(border)) break;
  }
  return promiseOf();
}

void BandSearch::holdAtLimits(std::vector<VectorXd>& border) {
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    const VectorXd& lower = problem_.lowerAt(of_[k]);
    const VectorXd& upper = problem_.upperAt(of_[k]);
    for (Eigen::Index i = 0; i < poses_[k].q.size(); ++i) {
      const double q = poses_[k].q[i];
      const double pull = undamped_.right[k][6 + i];
      const bool stays = (q <= lower[i] && pull <= 0.0) || (q >= upper[i] && pull >= 0.0);
      if (stays) hold(k, 6 + i, 0.0, border);
    }
  }
}

bool BandSearch::holdWhatLeaves(std::vector<VectorXd>& border) {
  bool left = false;
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    const VectorXd& lower = problem_.lowerAt(of_[k]);
    const VectorXd& upper = problem_.upperAt(of_[k]);
    for (Eigen::Index i = 0; i < poses_[k].q.size(); ++i) {
      if (border[k][6 + i] != kFree) continue;
      const double q = poses_[k].q[i];
      const double inside = std::clamp(q + steps_[k][6 + i], lower[i], upper[i]) - q;
      if (std::abs(inside - steps_[k][6 + i]) < 1e-12) continue;
      hold(k, 6 + i, inside, border);
      left = true;
    }
  }
  return left;
}

void BandSearch::hold(std::size_t k,
                      Eigen::Index i,
                      double way,
                      std::vector<VectorXd>& border) {
  border[k][i] = way;
  if (way != 0.0) {
    system_.right[k] -= way * system_.own[k].col(i);
    const auto to_other = [&](std::size_t other, double entry) {
      if (border[other][i] == kFree) system_.right[other][i] -= way * entry;
    };
    const std::size_t frames = poses_.size();
    if (k + 1 < frames) to_other(k + 1, system_.next[k].others[i - 3]);
    if (k + 2 < frames) to_other(k + 2, system_.after_next[k].others[i - 3]);
    if (k >= 1) to_other(k - 1, system_.next[k - 1].others[i - 3]);
    if (k >= 2) to_other(k - 2, system_.after_next[k - 2].others[i - 3]);
    // Those held in this frame before go their own way.
    for (Eigen::Index j = 6; j < border[k].size(); ++j)
      if (j != i && border[k][j] != kFree) system_.right[k][j] = border[k][j];
  }
  system_.own[k].row(i).setZero();
  system_.own[k].col(i).setZero();
  system_.own[k](i, i) = 1.0;
  system_.right[k][i] = way;
  system_.next[k].others[i - 3] = system_.after_next[k].others[i - 3] = 0.0;
  if (k >= 1) system_.next[k - 1].others[i - 3] = 0.0;
  if (k >= 2) system_.after_next[k - 2].others[i - 3] = 0.0;
}

VectorXd BandSearch::dampingOf(std::size_t k) const {
  const VectorXd& scale = objective_.models()[k].scale;
  return damping_[k] * scale.cwiseMax(kLeastScale * stiffest_).cwiseMax(1e-6);
}

double BandSearch::promiseOf() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const VectorXd& step = steps_[k];
    sum += undamped_.right[k].dot(step) - 0.5 * step.dot(undamped_.own[k] * step);
    for (const std::size_t ahead : {1, 2}) {
      if (k + ahead >= steps_.size()) continue;
      const Coupling& coupling = (ahead == 1 ? undamped_.next : undamped_.after_next)[k];
      const VectorXd& other = steps_[k + ahead];
      sum -= other.head<3>().dot(coupling.turn * step.head<3>()) +
             other.tail(other.size() - 3)
                 .dot(coupling.others.cwiseProduct(step.tail(step.size() - 3)));
    }
  }
  return sum;
}

bool BandSearch::judgeFrames(bool better) {
  bool any = false;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const double expected = objective_.models()[k].changeBy(steps_[k]);
    const double error = objective_.frames()[k] - frames_[k] - expected;
    const double size = std::abs(expected) + 1e-4 * frames_[k];
    if (error > 0.5 * size) {
      damping_[k] = std::min(kMostDamping, kRaised * damping_[k]);
      any = true;
    } else if (better && error < 0.2 * size) {
      damping_[k] = std::max(kLeastDamping, damping_[k] / 3.0);
    }
  }
  return any;
}

}  // namespace handgraft::manipulation
