#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

enum class Solver { kMma, kCcsaq, kSlsqp, kLbfgs, kTnewton, kVar2 };

/// `mma ccsaq slsqp lbfgs tnewton var2`; InvalidInput names them.
Solver solverFrom(std::string_view name);
std::string_view nameOf(Solver solver);

inline constexpr Solver kDefaultSolver = Solver::kMma;
inline constexpr int kDefaultStarts = 12;

struct SolveOptions {
  Solver solver = kDefaultSolver;
  /// Start 0 is the problem's own; start 1 its joints under the closed-form alignment; the
  /// others put seeded joints (low-discrepancy, within the limits) under that alignment.
  int starts = kDefaultStarts;
  int threads = 1;
  unsigned seed = 0;
  int max_evaluations = 1000;  ///< a start; the paper's cap
  /// Called from the solving threads, one at a time, with each better pose. What it throws ends
  /// the solve and is thrown from there.
  std::function<void(const hand::HandPose&, const Terms&)> on_improvement;
};

/// Minimises Eq. 2 over the root and the joints within their bounds; the best of all starts.
///
/// Every start gets the first 200 of its evaluations, the three best of them the rest. Bounds
/// that contradict each other give Outcome::kInfeasible and the start. With several threads the
/// listener of `progress` hears from each of them, one at a time.
///
/// Determinism: the same problem, options and seed give the same bytes, whatever `threads` is.
/// Errors: InvalidInput if the problem is not valid; Cancelled on wish.
/// Cost: O(pairs) once, then 2-4 us an evaluation for 26 degrees of freedom with any number of
/// pairs
///   (SLSQP about 20 us of its own).
SolveReport solve(const PoseProblem& problem,
                  const SolveOptions& options,
                  const Progress& progress);

/// Root pose that brings the pairs together best with the joints held at q: closed form over
/// points and normals (Kabsch/Umeyama without scale, SVD), no start needed.
///
/// `normal_length_m` turns a normal's mismatch into metres. With fewer than three pairs, or
/// pairs that do not fix the rotation, the answer is still a proper rotation, and
/// deterministic.
Pose alignRoot(const PoseProblem& problem,
               const Eigen::VectorXd& q,
               double normal_length_m = 0.01);

}  // namespace handgraft::optimize
