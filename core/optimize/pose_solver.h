#pragma once

#include <memory>

#include "core/base/progress.h"
#include "core/optimize/solver.h"

namespace handgraft::optimize {

/// Solves one problem often: moments, scratch memory and threads are made once.
///
/// Not to be used by two threads at a time.
class PoseSolver {
 public:
  /// Errors: InvalidInput if the problem is not valid. Cost: O(pairs).
  explicit PoseSolver(PoseProblem problem);
  ~PoseSolver();

  PoseSolver(const PoseSolver&) = delete;
  PoseSolver& operator=(const PoseSolver&) = delete;

  /// `optimize::solve` but for what has to visit each pair: the report's terms are those of the
  /// moments, patches and limits are empty. Cost: independent of the number of pairs.
  SolveReport search(const SolveOptions& options, const Progress& progress);

  [[nodiscard]] const PoseProblem& problem() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Fills what `search` left out of a report of this problem: sums over the points, patches,
/// limits. Cost: O(pairs), and an evaluation.
void judge(const PoseProblem& problem, SolveReport& report);

/// The same of a pose that was evaluated as closely as can be: `terms` are the objective's
/// there.
void judge(const PoseProblem& problem, const Terms& terms, SolveReport& report);

}  // namespace handgraft::optimize
