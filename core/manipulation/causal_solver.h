#pragma once

#include <optional>

#include "core/base/progress.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/trajectory.h"
#include "core/optimize/near_samples.h"
#include "core/optimize/solve_report.h"

namespace handgraft::manipulation {

/// Follows contacts frame by frame, each frame from those before it alone: for live streams.
///
/// A frame minimises its Eq. 2 plus smoothness times |x - what the last two frames lead to|^2,
/// within the joints' limits; velocity and acceleration narrow these to what can be reached,
/// and can be stopped from before a limit. Where limits contradict each other, those of the
/// position count most, then those of the velocity. A frame without contacts goes on over the
/// object until it rests.
///
/// Deterministic. Cost: some 5 to 20 evaluations of Eq. 2 a frame, warm.
/// Source: none; the paper solves frames from the one before, without saying more.
class CausalSolver {
 public:
  CausalSolver(const MotionProblem& problem, const MotionOptions& options);

  /// Where the hand is before the first frame, at rest.
  void begin(const hand::HandPose& X_OH);

  struct Step {
    hand::HandPose pose;
    double objective = 0.0;  ///< of Eq. 2 and penetration, without what makes it smooth
    int evaluations = 0;
  };

  /// The pose at `time_s`, behind the last one's, for `single` (FrameProblems::at).
  /// Errors: InvalidInput if the time does not rise; BrokenContract before `begin`.
  Step follow(double time_s, optimize::PoseProblem single);

 private:
  struct Past {
    double time_s = 0.0;
    hand::HandPose pose;
  };

  /// Where the last two frames lead.
  [[nodiscard]] hand::HandPose ahead(double step_s) const;
  void narrow(double step_s, optimize::PoseProblem& single) const;

  const MotionProblem& problem_;
  MotionOptions options_;
  bool waits_ = true;  ///< for the first frame
  std::optional<Past> last_;
  std::optional<Past> before_;
  double damping_ = 0.0;
  optimize::NearLists near_;
};

/// All frames one after the other, fades from the changes on. Begins at the best pose of the
/// first frame that has at least half as many pairs as the one with most: the hand waits there.
/// Errors: InvalidInput if the problem or the options are not valid; Cancelled on wish.
Trajectory solveCausal(const MotionProblem& problem,
                       const MotionOptions& options,
                       const Progress& progress);

/// The best pose of one frame alone: many starts, then out of the object.
/// Errors: Cancelled on wish.
optimize::SolveReport solveSingle(const MotionProblem& problem,
                                  const FrameProblems& frames,
                                  int frame,
                                  const hand::HandPose& start,
                                  const MotionOptions& options,
                                  const Progress& progress);

/// The first frame that has at least half as many pairs as the one with most; 0 without any.
int fullestBegin(const MotionProblem& problem, const FrameProblems& frames);

}  // namespace handgraft::manipulation
