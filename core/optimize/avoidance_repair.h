#pragma once

#include "core/base/progress.h"
#include "core/optimize/solver.h"

namespace handgraft::optimize {

/// `solve` of a problem with Avoidance: the search over all starts leaves the charge out, then
/// each minimum that it ranked, and the problem's own start, goes downhill with it: 25
/// evaluations, the best two up to 200, so that the answer may end at that limit. The report's
/// minima are those with the charge.
///
/// Determinism, errors: as `solve`. Cost: some 10 ms more than without.
SolveReport solveAvoiding(const PoseProblem& problem,
                          const SolveOptions& options,
                          const Progress& progress);

}  // namespace handgraft::optimize
