#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/optimize/align_root.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

enum class Solver {
  kLm,   ///< ours: bounded Levenberg-Marquardt with an active set (newton_search.h)
  kMma,  ///< the paper's, by NLopt, like the others
  kCcsaq,
  kSlsqp,
  kLbfgs,
  kTnewton,
  kVar2,
  kAll,  ///< each of them in turn; the report ranks what they found
};

/// `lm mma ccsaq slsqp lbfgs tnewton var2 all`; InvalidInput names them.
Solver solverFrom(std::string_view name);
std::string_view nameOf(Solver solver);

/// All but `all`.
std::vector<Solver> singleSolvers();

inline constexpr Solver kDefaultSolver = Solver::kLm;
inline constexpr int kDefaultStarts = 64;
inline constexpr int kDefaultEvaluations = 1000;  ///< a start; the paper's cap

inline constexpr double kLeastPromise = 1e-9;

struct NearLists;

struct SolveOptions {
  Solver solver = kDefaultSolver;
  /// Start 0 is the problem's own; the next ones its joints, the prior's and the rest pose's
  /// under the closed-form alignment; the others are spread over joints and turns (starts.h).
  int starts = kDefaultStarts;  ///< at most
  int threads = 1;
  unsigned seed = 0;
  int max_evaluations = kDefaultEvaluations;  ///< a start
  /// Of `lm`: share of the objective; a search whose next step promises less has ended.
  double least_promise = kLeastPromise;
  /// Start 0 is the prior instead of the problem's start.
  bool from_prior = false;
  /// How closely all starts look for penetration, where the problem charges it. `solve` goes on
  /// from what they find, closer and closer, up to all of it; PoseSolver alone does not.
  AvoidanceLevel level;
  /// What a search of this problem, or of one much like it, found without the charge for
  /// penetration: it is not searched again.
  std::vector<Minimum> found;
  /// What a solve leaves there the next one begins with, if hand and object are the same: the
  /// same answer, sooner where it begins near. For one solve at a time; null: begins anew.
  NearLists* near = nullptr;
  /// Called from the solving threads, one at a time, with each better pose. What it throws ends
  /// the solve and is thrown from there.
  std::function<void(const hand::HandPose&, const Terms&)> on_improvement;
};

/// The paper's own way: one start, the prior, which follows the last result; MMA.
SolveOptions paperOptions();

/// Minimises Eq. 2 over the root and the joints within their bounds; the best of all starts.
///
/// Every start gets the first part of its evaluations, the most promising quarter of them the
/// rest. The last three eighths of the starts are about the best places found, and are left out
/// where the others agree on the best.
/// Bounds that contradict each other give Outcome::kInfeasible and the start. With
/// several threads the listener of `progress` hears from each of them, one at a time.
///
/// Determinism: the same problem, options and seed give the same bytes, whatever `threads` is.
/// Errors: InvalidInput if the problem is not valid; Cancelled on wish.
/// Cost: O(pairs) once, then about 0.1 ms a start of `lm` for 26 degrees of freedom with any
///   number of pairs; 1-3 ms of the others. `PoseSolver` prepares once and solves often.
SolveReport solve(const PoseProblem& problem,
                  const SolveOptions& options,
                  const Progress& progress);

}  // namespace handgraft::optimize
