#pragma once

#include "core/base/progress.h"
#include "core/optimize/solver.h"

namespace handgraft::optimize {

/// Up to so many starts are a step from where the hand stands, out of the object already.
inline constexpr int kFewStarts = 4;

/// `solve` of a problem with Avoidance: the search over all starts leaves the charge out; the
/// minima that it ranked, the problem's own start and the prior's joints are judged with the
/// charge and go downhill with more and more of it: eight by few samples and softly, four by
/// all samples, three to the full charge; of those that stand close together one goes on. The
/// best goes to its end, once fingers that have run through each other there were tried anew
/// from the rest pose. Of few starts one goes on, not to its end; a lone one is a step from
/// where it stands. The report's minima are those with the charge.
///
/// Determinism, errors: as `solve`. Cost: some 10 ms more than without; 2 ms of few starts.
SolveReport solveAvoiding(const PoseProblem& problem,
                          const SolveOptions& options,
                          const Progress& progress);

}  // namespace handgraft::optimize
