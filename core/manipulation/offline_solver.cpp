#include "core/manipulation/offline_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/manipulation/motion_objective.h"
#include "core/manipulation/motion_starts.h"

namespace handgraft::manipulation {

namespace {

using Eigen::VectorXd;
using Poses = std::vector<hand::HandPose>;

constexpr double kFirstDamping = 1e-2;
constexpr double kLeastDamping = 1e-6;
constexpr double kMostDamping = 1e9;
constexpr double kWorthwhile = 1e-5;  // share of the objective that a step has to promise
constexpr double kEnough = 5e-4;
constexpr double kNearlyEnough = 1e-3;  // where each evaluation looks at thousands of samples
// Of the stiffest frame's diagonal: frames without contacts are damped by that share of it.
constexpr double kLeastScale = 1e-2;
constexpr double kLeastRatio = 1e-4;
constexpr double kRaised = 10.0;         // the damping of a frame whose model was wrong
constexpr double kShortestShare = 0.01;  // of a step

/// One part of the way: how closely penetration is looked for, how much of smoothness and of
/// what lies beyond velocities and accelerations is charged, and for how long.
struct Stage {
  optimize::AvoidanceLevel level;
  double smoothness;
  double limits;
  int steps;
  double enough = kEnough;  ///< share of the objective that a step has to gain for another
};

constexpr optimize::AvoidanceLevel kTouch = {false, 0.0};
constexpr optimize::AvoidanceLevel kClosely = {true, 1.0};
constexpr optimize::AvoidanceLevel kFirmly = {true, 16.0};

// From soft to hard: what is stiff at once is stuck at once.
const std::vector<Stage> touching_stages = {
    {kTouch, 1.0, 1e-4, 40}, {kTouch, 1.0, 1e-2, 40}, {kTouch, 1.0, 1.0, 60}};
// Out of the object already, and to stay there while the way grows smooth.
const std::vector<Stage> avoiding_stages = {{kClosely, 0.05, 1e-3, 4, kNearlyEnough},
                                            {kClosely, 1.0, 1.0, 16, kNearlyEnough},
                                            {kFirmly, 1.0, 1.0, 10, kNearlyEnough}};

// Where velocities or accelerations are beyond their limits still: firmer and firmer; and where
// that is stuck, by a way so smooth that it keeps them, which is let go bit by bit.
const std::vector<Stage> touching_limited = {
    {kTouch, 1.0, 10.0, 40}, {kTouch, 1.0, 100.0, 40}, {kTouch, 1.0, 1000.0, 40}};
const std::vector<Stage> avoiding_limited = {{kFirmly, 1.0, 10.0, 20, kNearlyEnough},
                                             {kFirmly, 1.0, 100.0, 20, kNearlyEnough},
                                             {kFirmly, 1.0, 1000.0, 20, kNearlyEnough}};
const std::vector<Stage> touching_smoothed = {{kTouch, 1000.0, 1.0, 40},
                                              {kTouch, 100.0, 100.0, 40},
                                              {kTouch, 10.0, 1000.0, 40},
                                              {kTouch, 1.0, 1e4, 40}};
const std::vector<Stage> avoiding_smoothed = {{kFirmly, 1000.0, 1.0, 20, kNearlyEnough},
                                              {kFirmly, 100.0, 100.0, 20, kNearlyEnough},
                                              {kFirmly, 10.0, 1000.0, 20, kNearlyEnough},
                                              {kFirmly, 1.0, 1e4, 30, 1e-4}};

// From an answer that stands already, beside what was edited.
const std::vector<Stage> touching_again = {{kTouch, 1.0, 1.0, 60}};
const std::vector<Stage> avoiding_again = {{kClosely, 1.0, 1.0, 12, kNearlyEnough},
                                           {kFirmly, 1.0, 1.0, 10, kNearlyEnough}};

// Of a step among others.
const std::vector<Stage> touching_step = {{kTouch, 1.0, 1.0, 6}};
const std::vector<Stage> avoiding_step = {{kClosely, 1.0, 1.0, 4, kNearlyEnough}};

/// Frames that stay as they are, at both ends of a part.
struct Held {
  std::size_t before = 0;
  std::size_t behind = 0;
};

/// A Newton method over all frames, from one trajectory downhill. Each frame has a damping of
/// its own, raised where its model was wrong: a frame in trouble does not keep the others back.
class BandSearch {
 public:
  /// Of the motion's frames from `first` on.
  BandSearch(const MotionProblem& problem,
             MotionObjective& objective,
             std::size_t first,
             Poses poses,
             Held held)
      : problem_(problem),
        objective_(objective),
        first_(first),
        held_(held),
        system_(poses.size(), objective.dofCount()),
        undamped_(system_),
        poses_(std::move(poses)),
        damping_(poses_.size(), kFirstDamping) {}

  /// Up to `steps` trials. Counts evaluations of frames.
  void descend(const Stage& stage, const Progress& progress, int& evaluations) {
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

  /// Eq. 2 of each frame.
  [[nodiscard]] const std::vector<double>& frames() const { return frames_; }

  [[nodiscard]] Poses& poses() { return poses_; }

 private:
  /// What the poses come to by the stage's measure.
  void beginStage(const Stage& stage, int& evaluations) {
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

  /// Shortens the steps until they gain some of what they promise; whether they do. `value`
  /// becomes that of where they lead.
  bool shorten(double promise, double& value, int& evaluations) {
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

  void raiseDamping() {
    for (double& damping : damping_)
      damping = std::min(kMostDamping, 10.0 * damping);
  }

  /// Where the steps lead; what is held stays to the byte.
  void moveTrial() {
    moveBy(problem_, first_, steps_, poses_, trial_);
    const std::size_t frames = poses_.size();
    for (std::size_t k = 0; k < frames; ++k)
      if (isHeld(k)) trial_[k] = poses_[k];
  }

  [[nodiscard]] bool isHeld(std::size_t k) const {
    return k < held_.before || k + held_.behind >= poses_.size();
  }

  void expand() {
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

  /// A step of each frame within the limits of its joints, and what it promises to gain. Joints
  /// that would leave stay on the border, and the others follow.
  double propose() {
    constexpr int kPasses = 4;
    system_ = undamped_;
    for (std::size_t k = 0; k < poses_.size(); ++k)
      system_.own[k].diagonal() += dampingOf(k);
    std::vector<VectorXd> border(poses_.size(),
                                 VectorXd::Constant(objective_.dofCount(), kFree));
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

  /// Joints at a limit, where they are pulled beyond it.
  void holdAtLimits(std::vector<VectorXd>& border) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const VectorXd& lower = problem_.lowerAt(static_cast<int>(first_ + k));
      const VectorXd& upper = problem_.upperAt(static_cast<int>(first_ + k));
      for (Eigen::Index i = 0; i < poses_[k].q.size(); ++i) {
        const double q = poses_[k].q[i];
        const double pull = undamped_.right[k][6 + i];
        const bool stays = (q <= lower[i] && pull <= 0.0) || (q >= upper[i] && pull >= 0.0);
        if (stays) hold(k, 6 + i, 0.0, border);
      }
    }
  }

  /// Joints that a step takes beyond a limit, at that limit; whether there were any.
  bool holdWhatLeaves(std::vector<VectorXd>& border) {
    bool left = false;
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const VectorXd& lower = problem_.lowerAt(static_cast<int>(first_ + k));
      const VectorXd& upper = problem_.upperAt(static_cast<int>(first_ + k));
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

  /// Degree of freedom i of frame k goes `way`, whatever the others do.
  void hold(std::size_t k, Eigen::Index i, double way, std::vector<VectorXd>& border) {
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

  [[nodiscard]] VectorXd dampingOf(std::size_t k) const {
    const VectorXd& scale = objective_.models()[k].scale;
    return damping_[k] * scale.cwiseMax(kLeastScale * stiffest_).cwiseMax(1e-6);
  }

  /// What the undamped model says of the steps.
  [[nodiscard]] double promiseOf() const {
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

  /// Raises the damping of frames whose own model was wrong at the trial, and lowers that of
  /// others if it was `better`; whether there was any to raise.
  bool judgeFrames(bool better) {
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

  static constexpr double kFree = std::numeric_limits<double>::infinity();

  const MotionProblem& problem_;
  MotionObjective& objective_;
  std::size_t first_;
  Held held_;
  BandSystem system_;
  BandSystem undamped_;
  BandCholesky cholesky_;
  Poses poses_;
  Poses trial_;
  std::vector<VectorXd> steps_;
  std::vector<double> damping_;
  VectorXd stiffest_;  ///< of each degree of freedom, over all frames
  std::vector<double> frames_;
  double value_ = 0.0;
  std::optional<optimize::AvoidanceLevel> level_;  ///< of `frames_`
  bool is_modelled_ = false;                       ///< the objective's models are of `poses_`
};

// A second difference joins a frame with the two before it.
constexpr std::size_t kJoined = 2;

/// The poses of the objective's frames, from `first` on.
void solvePart(const MotionProblem& problem,
               MotionObjective& objective,
               const std::vector<Stage>& stages,
               std::size_t first,
               Held held,
               const Progress& progress,
               Trajectory& trajectory) {
  const auto begin = trajectory.poses.begin() + static_cast<std::ptrdiff_t>(first);
  const std::size_t part = objective.frames().size();
  const std::size_t count = trajectory.poses.size();
  BandSearch search(problem, objective, first,
                    Poses(begin, begin + static_cast<std::ptrdiff_t>(part)), held);
  const bool is_limited = problem.velocity_limit.array().isFinite().any() ||
                          problem.acceleration_limit.array().isFinite().any();
  double done = 0.0;
  for (const Stage& stage : stages) {
    // Without limits of that kind nothing is stiff.
    if (!is_limited && problem.avoidance == nullptr && stage.limits < 1.0) continue;
    progress.report("solving all frames",
                    (static_cast<double>(first) + done * static_cast<double>(part)) /
                        static_cast<double>(count));
    done += 1.0 / static_cast<double>(stages.size());
    search.descend(stage, progress, trajectory.evaluations);
  }
  std::copy(search.frames().begin(), search.frames().end(),
            trajectory.objective.begin() + static_cast<std::ptrdiff_t>(first));
  std::move(search.poses().begin(), search.poses().end(), begin);
}

/// Frames `first` to `end`, in parts; before them and from `end` on poses stay.
void solveParts(const MotionProblem& problem,
                const MotionOptions& options,
                const std::vector<Stage>& stages,
                std::size_t first,
                std::size_t end,
                const Progress& progress,
                Trajectory& trajectory) {
  optimize::WorkerPool pool(options.threads);
  const FrameProblems frames(problem, options.fade);
  const std::size_t count = problem.time_s.size();
  const auto at_once = static_cast<std::size_t>(options.frames_at_once);
  // Frames that are solved with one part for its sake, and with the next for good.
  const std::size_t ahead = std::min<std::size_t>(480, at_once / 4);
  std::size_t from = first - std::min(kJoined, first);
  const std::size_t to = std::min(count, end + kJoined);
  Held held{first - from, 0};
  for (;;) {
    const std::size_t left = to - from;
    const std::size_t part = left <= at_once + ahead ? left : at_once;
    held.behind = part == left ? to - end : 0;
    MotionObjective objective(problem, frames, options, pool, from, part);
    solvePart(problem, objective, stages, from, held, progress, trajectory);
    if (part == left) return;
    from += part - ahead - kJoined;
    held.before = kJoined;
  }
}

/// How many times its limit a velocity or an acceleration is, at most.
double limitShare(const MotionProblem& problem, const Trajectory& trajectory) {
  const Smoothness smoothness = measureSmoothness(problem, trajectory.poses);
  return std::max(smoothness.velocity_share, smoothness.acceleration_share);
}

/// What lies beyond a limit costs, and a tight one asks for more than a cost: it is brought
/// within, as far as that goes; where it does not, that is noted.
void keepLimits(const MotionProblem& problem,
                const MotionOptions& options,
                std::size_t first,
                std::size_t end,
                const Progress& progress,
                Trajectory& trajectory) {
  const bool touches = problem.avoidance == nullptr;
  double share = limitShare(problem, trajectory);
  for (const auto* stages : {touches ? &touching_limited : &avoiding_limited,
                             touches ? &touching_smoothed : &avoiding_smoothed}) {
    if (share <= 1.0) return;
    Trajectory kept = trajectory;
    solveParts(problem, options, *stages, first, end, progress, kept);
    const double kept_share = limitShare(problem, kept);
    if (kept_share >= share) continue;
    share = kept_share;
    trajectory = std::move(kept);
  }
  constexpr double kWorthNoting = 1.01;
  if (share > kWorthNoting)
    trajectory.notes.push_back(fmt::format(
        "a joint's velocity or acceleration comes to {:.2f} times its limit", share));
}

}  // namespace

Trajectory solveOffline(const MotionProblem& problem,
                        const MotionOptions& options,
                        const Progress& progress,
                        const std::vector<hand::HandPose>& start,
                        const std::vector<FramePose>& known) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(start.empty() || start.size() == problem.time_s.size());
  for (const FramePose& one : known)
    HANDGRAFT_REQUIRE(one.frame >= 0 && one.frame < problem.frameCount());
  Trajectory trajectory;
  trajectory.time_s = problem.time_s;
  trajectory.poses = start;
  if (trajectory.poses.empty()) {
    trajectory.poses = problem.avoidance == nullptr
                           ? joinedMinima(problem, options, progress)
                           : followedMinima(problem, options, progress, known);
  }
  trajectory.objective.assign(trajectory.poses.size(), 0.0);
  solveParts(problem, options, problem.avoidance == nullptr ? touching_stages : avoiding_stages,
             0, problem.time_s.size(), progress, trajectory);
  keepLimits(problem, options, 0, problem.time_s.size(), progress, trajectory);
  return trajectory;
}

void solveAgain(const MotionProblem& problem,
                const MotionOptions& options,
                int first,
                int end,
                const Progress& progress,
                Trajectory& trajectory) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(trajectory.poses.size() == problem.time_s.size());
  HANDGRAFT_REQUIRE(0 <= first && first < end && end <= problem.frameCount());
  for (int k = first; k < end; ++k) {
    Eigen::VectorXd& q = trajectory.poses[static_cast<std::size_t>(k)].q;
    q = q.cwiseMax(problem.lowerAt(k)).cwiseMin(problem.upperAt(k));
  }
  solveParts(problem, options, problem.avoidance == nullptr ? touching_again : avoiding_again,
             static_cast<std::size_t>(first), static_cast<std::size_t>(end), progress,
             trajectory);
  keepLimits(problem, options, static_cast<std::size_t>(first), static_cast<std::size_t>(end),
             progress, trajectory);
}

void stepOn(const MotionProblem& problem,
            const MotionOptions& options,
            const Progress& progress,
            Trajectory& trajectory) {
  validate(problem);
  validate(options);
  HANDGRAFT_REQUIRE(trajectory.poses.size() == problem.time_s.size());
  solveParts(problem, options, problem.avoidance == nullptr ? touching_step : avoiding_step, 0,
             problem.time_s.size(), progress, trajectory);
}

}  // namespace handgraft::manipulation
