#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/optimize/solve_report.h"
#include "core/session/session.h"

namespace handgraft::session {

/// What it would bring the others to switch one patch off.
struct PatchInTheWay {
  int patch = -1;   ///< of the session's; -1: none is in the way
  int reached = 0;  ///< of the others, then
  int others = 0;   ///< that are asked for
};

/// Where two and more of at most twelve patches are missed: the one without which a solve
/// reaches more than are reached now, and more than by solving once more with all of them.
///
/// What is said has been done: with that patch switched off the session was solved in full, at
/// once and after the short search that answers an edit, and both reached so many. The others
/// are tried in the order of that short search, six at most; the most reached counts, of as
/// many the first, and the first that leaves nothing missed ends it. The session stays what it
/// is.
///
/// `problem`, `report`: the session's pose as it stands. `never_reached`: patches that do not
/// count as reached whatever a pose says. The same on any number of threads.
/// Errors: BrokenContract unless the report is the problem's and the problem the session's.
/// Cancelled on wish, within one of those solves.
/// Cost: nothing where fewer are missed; else a short search a patch, a solve with all, and one
/// or two solves for each of those that are tried: 0.05 to 1 s.
PatchInTheWay patchInTheWay(const Session& session,
                            const optimize::PoseProblem& problem,
                            const optimize::SolveReport& report,
                            const std::vector<int>& never_reached,
                            int threads,
                            const Progress& progress);

}  // namespace handgraft::session
