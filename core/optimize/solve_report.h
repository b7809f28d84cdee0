#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/hand/kinematics.h"
#include "core/optimize/objective.h"

namespace handgraft::optimize {

enum class Outcome {
  kConverged,        ///< the gradient, or what the last steps gained, promises nothing more
  kStalled,          ///< the solver gave up (rounding, no progress) before that
  kEvaluationLimit,  ///< evaluations ran out first
  kInfeasible,       ///< the bounds contradict each other; the pose is the start
};

/// `converged`, `stalled`, `evaluation_limit`, `infeasible`.
std::string_view nameOf(Outcome outcome);

/// How well one patch is reached.
struct PatchFit {
  int patch = -1;
  int point_count = 0;
  double mean_mm = 0.0;
  double rms_mm = 0.0;
  double max_mm = 0.0;
  double normal_mean_deg = 0.0;  ///< between n_hand and -n_object
  double within_2mm = 0.0;       ///< share in [0, 1]
  double within_5mm = 0.0;
};

/// A joint that stands at its limit, within 1e-6 rad or m; a joint without a range stands at
/// its lower one.
struct ActiveLimit {
  int dof = 0;  ///< of the hand
  bool upper = false;
};

/// A place where searches ended, one of several that differ.
struct Minimum {
  hand::HandPose pose;
  Terms terms;
  Outcome outcome = Outcome::kStalled;
  std::string solver;
  int start = 0;  ///< that ended there first
  int hits = 1;   ///< how many did
};

/// The answer to a problem: always a pose, also when it is a poor one.
struct SolveReport {
  Outcome outcome = Outcome::kStalled;
  std::string solver;
  hand::HandPose pose;
  Terms terms;          ///< summed over the points, not over their moments
  int evaluations = 0;  ///< of all starts
  int starts = 0;       ///< searched from
  int best_start = 0;
  /// Distinct minima by rising objective, the answer first; at most eight.
  std::vector<Minimum> minima;
  std::vector<PatchFit> patches;
  std::vector<ActiveLimit> active_limits;
};

/// Fit of every patch of the problem at `pose`, in the order of their numbers; pairs that
/// belong to no patch (-1) appear in none. Weights play no part. Errors: InvalidInput if the
/// problem is not valid; BrokenContract on a pose of another hand.
std::vector<PatchFit> fitPatches(const PoseProblem& problem, const hand::HandPose& pose);

/// Eq. 2-5 at `pose`, pair by pair: no digits are lost near a perfect fit. What is no sum over
/// pairs, prior and penetration, is that of `terms` there. Cost: O(pairs).
Terms sumOverPoints(const PoseProblem& problem, const hand::HandPose& pose, Terms terms);

/// The same where nobody has evaluated that pose. Cost: as Objective::evaluate, too.
Terms sumOverPoints(const PoseProblem& problem, const hand::HandPose& pose);

/// The joints of `pose` at their limits, locked ones left out, in the order of the dofs.
std::vector<ActiveLimit> activeLimits(const PoseProblem& problem, const hand::HandPose& pose);

/// The same of bounds alone; what they hold in one place is locked.
std::vector<ActiveLimit> activeLimits(const Eigen::VectorXd& lower,
                                      const Eigen::VectorXd& upper,
                                      const Eigen::VectorXd& q);

}  // namespace handgraft::optimize
