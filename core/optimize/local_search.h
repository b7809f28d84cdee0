#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/optimize/nlopt_solver.h"
#include "core/optimize/objective.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

/// Where a search from one start stands.
struct LocalResult {
  hand::HandPose pose;  ///< the best one seen
  Terms terms;
  int evaluations = 0;
  Outcome outcome = Outcome::kEvaluationLimit;
};

/// Minimises Eq. 2 from one start, in variables that suit the solver. One per thread.
///
/// Variables: increments about the start, the rotation's on the manifold, R = exp(w) R_start,
/// so that no start is near the chart's singularity; when the best |w| grows past 2 rad, or a
/// solver stops early, the search starts anew about the best pose with the evaluations left.
/// Locked degrees of freedom are no variables. Each is scaled by the root of its stiffness over
/// the objective, which makes metres and radians comparable and the function of the order of
/// one: SLSQP aborts on large values, the others are slow without it.
class LocalSearch {
 public:
  /// Sees each better pose; may throw, which ends the search with that exception.
  using Observer = std::function<void(const hand::HandPose&, const Terms&)>;

  /// Keeps references to all three. `keep_going` is asked before every evaluation and may
  /// throw.
  LocalSearch(const PoseProblem& problem,
              const Observer& observer,
              const std::function<void()>& keep_going);

  /// The start's joints are moved into their bounds.
  LocalResult begin(hand::HandPose start);

  /// Improves `result` with up to `evaluations` more.
  /// Cost: about 2 us an evaluation for 26 degrees of freedom, plus the solver's own.
  void advance(Solver solver, int evaluations, LocalResult& result);

 private:
  Stop runOnce(Solver solver, int evaluations, LocalResult& result);
  bool isStationary(const LocalResult& result);

  const PoseProblem& problem_;
  const Observer& observer_;
  const std::function<void()>& keep_going_;
  Objective objective_;
  std::vector<int> free_dofs_;
  Eigen::VectorXd lower_;  ///< of the free ones
  Eigen::VectorXd upper_;
  bool rotation_partly_locked_ = false;
  Eigen::VectorXd gradient_;
};

}  // namespace handgraft::optimize
