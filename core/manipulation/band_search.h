#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/manipulation/band_system.h"
#include "core/manipulation/motion_objective.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::manipulation {

/// One part of the way: how closely penetration is looked for, how much of smoothness and of
/// what lies beyond velocities and accelerations is charged, and for how long.
struct SearchStage {
  static constexpr double kEnough = 5e-4;

  optimize::AvoidanceLevel level;
  double smoothness;
  double limits;
  int steps;
  double enough = kEnough;  ///< share of the objective that a step has to gain for another
};

/// Frames that stay as they are, at both ends of a part.
struct HeldFrames {
  std::size_t before = 0;
  std::size_t behind = 0;
};

/// A Newton method over all frames, from one trajectory downhill. Each frame has a damping of
/// its own, raised where its model was wrong: a frame in trouble does not keep the others back.
class BandSearch {
 public:
  using Poses = std::vector<hand::HandPose>;

  /// Of these frames of the motion, which are the objective's.
  BandSearch(const MotionProblem& problem,
             MotionObjective& objective,
             std::vector<int> frames,
             Poses poses,
             HeldFrames held)
      : problem_(problem),
        objective_(objective),
        of_(std::move(frames)),
        held_(held),
        system_(poses.size(), objective.dofCount()),
        undamped_(system_),
        poses_(std::move(poses)),
        damping_(poses_.size()) {}

  /// Up to `steps` steps, each of them tried, shortened where nothing else helps. Counts
  /// evaluations of frames.
  void descend(const SearchStage& stage, const Progress& progress, int& evaluations);

  /// Eq. 2 of each frame, once it has descended.
  [[nodiscard]] const std::vector<double>& frames() const { return frames_; }

  [[nodiscard]] Poses& poses() { return poses_; }

 private:
  /// What the poses come to by the stage's measure.
  void beginStage(const SearchStage& stage, int& evaluations);

  /// Shortens the steps until they gain some of what they promise; whether they do. `value`
  /// becomes that of where they lead.
  bool shorten(double promise, double& value, int& evaluations);

  void raiseDamping();

  /// Where the steps lead; what is held stays to the byte.
  void moveTrial();

  [[nodiscard]] bool isHeld(std::size_t k) const;

  void expand();

  /// A step of each frame within the limits of its joints, and what it promises to gain. Joints
  /// that would leave stay on the border, and the others follow.
  double propose();

  /// Joints at a limit, where they are pulled beyond it.
  void holdAtLimits(std::vector<Eigen::VectorXd>& border);

  /// Joints that a step takes beyond a limit, at that limit; whether there were any.
  bool holdWhatLeaves(std::vector<Eigen::VectorXd>& border);

  /// Degree of freedom i of frame k goes `way`, whatever the others do.
  void hold(std::size_t k, Eigen::Index i, double way, std::vector<Eigen::VectorXd>& border);

  [[nodiscard]] Eigen::VectorXd dampingOf(std::size_t k) const;

  /// What the undamped model says of the steps.
  [[nodiscard]] double promiseOf() const;

  /// Raises the damping of frames whose own model was wrong at the trial, and lowers that of
  /// others if it was `better`; whether there was any to raise.
  bool judgeFrames(bool better);

  static constexpr double kFree = std::numeric_limits<double>::infinity();

  const MotionProblem& problem_;
  MotionObjective& objective_;
  std::vector<int> of_;  ///< of the motion
  HeldFrames held_;
  BandSystem system_;
  BandSystem undamped_;
  BandCholesky cholesky_;
  Poses poses_;
  Poses trial_;
  std::vector<Eigen::VectorXd> steps_;
  std::vector<double> damping_;
  Eigen::VectorXd stiffest_;  ///< of each degree of freedom, over all frames
  std::vector<double> frames_;
  double value_ = 0.0;
  std::optional<optimize::AvoidanceLevel> level_;  ///< of `frames_`
  bool is_modelled_ = false;                       ///< the objective's models are of `poses_`
};

}  // namespace handgraft::manipulation
