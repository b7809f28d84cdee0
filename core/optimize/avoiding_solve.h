#pragma once

#include "core/base/progress.h"
#include "core/optimize/solver.h"

namespace handgraft::optimize {

/// `solve` of a problem with Avoidance: the search over all starts leaves the charge out; the
/// minima that it ranked, and the problem's own start, are judged with the charge and go
/// downhill with more and more of it: nine by few samples and softly, four by all samples, two
/// to the full charge. The answer may end at that limit. Of few starts one goes on.
/// The report's minima are those with the charge.
///
/// Determinism, errors: as `solve`. Cost: some 10 ms more than without; 2 ms of few starts.
SolveReport solveAvoiding(const PoseProblem& problem,
                          const SolveOptions& options,
                          const Progress& progress);

}  // namespace handgraft::optimize
