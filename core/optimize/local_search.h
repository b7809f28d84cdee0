#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/optimize/newton_search.h"
#include "core/optimize/nlopt_solver.h"
#include "core/optimize/objective.h"
#include "core/optimize/search_space.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

/// Where a search from one start stands.
struct LocalResult {
  hand::HandPose pose;  ///< the best one seen
  Terms terms;
  int evaluations = 0;
  Outcome outcome = Outcome::kEvaluationLimit;
  double damping = 0.0;  ///< of `lm`, to go on with; 0: as it begins
};

/// What all searches of a problem share; made once.
struct PreparedProblem {
  const PoseProblem& problem;
  std::shared_ptr<const MomentTree> tree;
  SearchSpace space;

  /// Keeps a reference. Cost: O(pairs).
  explicit PreparedProblem(const PoseProblem& source);
};

/// Minimises Eq. 2 from one start, in variables that suit the solver. One per thread.
///
/// `lm` works on the coordinates themselves (newton_search.h). The others see increments about
/// the start, the rotation's on the manifold, R = exp(w) R_start,
/// so that no start is near the chart's singularity; when the best |w| grows past 2 rad, or a
/// solver stops early, the search starts anew about the best pose with the evaluations left.
/// Locked degrees of freedom are no variables. Each is scaled by the root of its stiffness over
/// the objective, which makes metres and radians comparable and the function of the order of
/// one: SLSQP aborts on large values, the others are slow without it.
class LocalSearch {
 public:
  /// Sees each better pose; may throw, which ends the search with that exception.
  using Observer = std::function<void(const hand::HandPose&, const Terms&)>;

  /// Keeps a reference.
  explicit LocalSearch(const PreparedProblem& prepared);

  /// Who hears of better poses, and what is asked before every evaluation and may throw. Both
  /// are kept by reference.
  void attend(const Observer& observer, const std::function<void()>& keep_going);

  /// How closely penetration is looked for, where the problem charges it. Results of searches
  /// before have another objective: `begin` them anew.
  void level(const AvoidanceLevel& level) { objective_.level(level); }

  /// As AvoidanceTerm::swapNear.
  void swapNear(NearLists& near) { objective_.swapNear(near); }

  /// From now on; of `lm` alone (SolveOptions::least_promise).
  void endBelow(double promise) { newton_.settings.promise = promise; }

  /// The start's joints are moved into their bounds. Costs an evaluation, which is all of it
  /// unless `warm_up` more may be spent on |n_h + n_o|^2 in place of Eq. 4: a slope where that
  /// has none, as in a flipped hand.
  LocalResult begin(hand::HandPose start, int warm_up = 0);

  /// Improves `result` with up to `evaluations` more.
  /// Cost: 2 us an evaluation of `lm` for 26 degrees of freedom and 4 us a step; 2 us an
  ///   evaluation of the others plus their own.
  void advance(Solver solver, int evaluations, LocalResult& result);

 private:
  void warmUp(int evaluations, LocalResult& result);
  void advanceByNewton(int evaluations, LocalResult& result);
  Stop runOnce(Solver solver, int evaluations, LocalResult& result);
  bool isStationary(const LocalResult& result);

  const PoseProblem& problem_;
  const SearchSpace& space_;
  const Observer* observer_ = nullptr;
  const std::function<void()>* keep_going_ = nullptr;
  Objective objective_;
  NewtonSearch newton_;
  Eigen::VectorXd gradient_;
};

}  // namespace handgraft::optimize
