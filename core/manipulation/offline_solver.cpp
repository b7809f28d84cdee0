#include "core/manipulation/offline_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/manipulation/motion_objective.h"
#include "core/manipulation/motion_starts.h"

namespace handgraft::manipulation {

namespace {

using Eigen::VectorXd;
using Poses = std::vector<hand::HandPose>;

constexpr double kFirstDamping = 1e-2;
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e9;
constexpr double kWorthwhile = 1e-6;  // share of the objective that a step has to promise
constexpr double kLeastRatio = 1e-4;

/// One part of the way: how closely penetration is looked for, how much of what lies beyond
/// velocities and accelerations is charged, and for how long.
struct Stage {
  optimize::AvoidanceCare care;
  double limits;
  int steps;
};

// From soft to hard: what is stiff at once is stuck at once.
const std::vector<Stage> kTouchingStages = {
    {{false, 0.0}, 1e-4, 40}, {{false, 0.0}, 1e-2, 40}, {{false, 0.0}, 1.0, 60}};
const std::vector<Stage> kAvoidingStages = {{{false, 0.0}, 1e-4, 12},
                                            {{false, 0.02}, 1e-3, 4},
                                            {{true, 0.1}, 1e-2, 6},
                                            {{true, 1.0}, 1.0, 25}};
const std::vector<Stage> kAvoidingFromStart = {{{true, 0.1}, 1e-2, 5}, {{true, 1.0}, 1.0, 25}};

/// A Newton method over all frames, from one trajectory downhill.
class BandSearch {
 public:
  BandSearch(const MotionProblem& problem, MotionObjective& objective, Poses poses)
      : problem_(problem),
        objective_(objective),
        system_(problem.time_s.size(), objective.dofCount()),
        poses_(std::move(poses)) {}

  /// Up to `steps` better trajectories. Counts evaluations of frames.
  void descend(int steps, const Progress& progress, int& evaluations) {
    value_ = objective_.evaluate(poses_);
    damping_ = kFirstDamping;
    double growth = 2.0;
    for (int step = 0; step < steps && damping_ < kMostDamping;) {
      progress.checkpoint();
      objective_.expand(poses_, true, system_);
      evaluations += problem_.frameCount();
      hold();
      const std::vector<Eigen::MatrixXd> undamped = system_.own;
      const std::vector<VectorXd> right = system_.right;
      bool better = false;
      while (!better && damping_ < kMostDamping) {
        progress.checkpoint();
        ++step;
        damp(undamped);
        if (!system_.solve(steps_)) {
          damping_ *= 10.0;
          continue;
        }
        const double promise = promiseOf(right);
        if (!(promise > kWorthwhile * value_)) return;
        moveBy(problem_, steps_, poses_, trial_);
        const double value = objective_.evaluate(trial_);
        evaluations += problem_.frameCount();
        const double ratio = (value_ - value) / promise;
        if (ratio > kLeastRatio) {
          std::swap(poses_, trial_);
          value_ = value;
          const double bend = 2.0 * std::min(ratio, 1.0) - 1.0;
          damping_ =
              std::max(kLeastDamping, damping_ * std::max(0.2, 1.0 - bend * bend * bend));
          growth = 2.0;
          better = true;
        } else {
          damping_ *= growth;
          growth *= 2.0;
        }
      }
    }
  }

  [[nodiscard]] Poses& poses() { return poses_; }

  [[nodiscard]] double value() const { return value_; }

 private:
  /// Joints at a limit that would leave it stay.
  void hold() {
    const Eigen::Index dofs = objective_.dofCount();
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      for (Eigen::Index i = 6; i < dofs; ++i) {
        const double q = poses_[k].q[i - 6];
        const bool stays = (q <= problem_.lower[i - 6] && system_.right[k][i] <= 0.0) ||
                           (q >= problem_.upper[i - 6] && system_.right[k][i] >= 0.0);
        if (!stays) continue;
        system_.own[k].row(i).setZero();
        system_.own[k].col(i).setZero();
        system_.own[k](i, i) = 1.0;
        system_.right[k][i] = 0.0;
        const Eigen::Index j = i - 3;
        system_.next[k].others[j] = system_.after_next[k].others[j] = 0.0;
        if (k >= 1) system_.next[k - 1].others[j] = 0.0;
        if (k >= 2) system_.after_next[k - 2].others[j] = 0.0;
      }
    }
  }

  void damp(const std::vector<Eigen::MatrixXd>& undamped) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const VectorXd& scale = objective_.scales()[k];
      const double floor = std::max(1e-6 * scale.maxCoeff(), 1e-6);
      system_.own[k] = undamped[k];
      system_.own[k].diagonal() += damping_ * scale.cwiseMax(floor);
    }
  }

  /// Half the gradient's way less half the damping's share: g s / 2 + s D s / 2.
  [[nodiscard]] double promiseOf(const std::vector<VectorXd>& right) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      const VectorXd& scale = objective_.scales()[k];
      const double floor = std::max(1e-6 * scale.maxCoeff(), 1e-6);
      sum += 0.5 * right[k].dot(steps_[k]) +
             0.5 * damping_ * steps_[k].cwiseAbs2().dot(scale.cwiseMax(floor));
    }
    return sum;
  }

  const MotionProblem& problem_;
  MotionObjective& objective_;
  BandSystem system_;
  Poses poses_;
  Poses trial_;
  std::vector<VectorXd> steps_;
  double value_ = 0.0;
  double damping_ = kFirstDamping;
};

}  // namespace

Trajectory solveOffline(const MotionProblem& problem,
                        const MotionOptions& options,
                        const Progress& progress,
                        const std::vector<hand::HandPose>& start) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(start.empty() || start.size() == problem.time_s.size());
  optimize::WorkerPool pool(options.threads);
  MotionObjective objective(problem, options, pool);
  Trajectory trajectory;
  trajectory.time_s = problem.time_s;
  BandSearch search(problem, objective,
                    start.empty() ? startPoses(problem, options, progress) : start);
  const std::vector<Stage>& stages = problem.avoidance == nullptr ? kTouchingStages
                                     : start.empty()              ? kAvoidingStages
                                                                  : kAvoidingFromStart;
  double done = 0.0;
  for (const Stage& stage : stages) {
    progress.report("solving all frames", done);
    done += 1.0 / static_cast<double>(stages.size());
    objective.care(stage.care);
    objective.chargeLimits(stage.limits);
    search.descend(stage.steps, progress, trajectory.evaluations);
  }
  trajectory.objective = objective.frames();
  trajectory.poses = std::move(search.poses());
  return trajectory;
}

}  // namespace handgraft::manipulation
