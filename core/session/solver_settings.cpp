#include "core/session/solver_settings.h"

#include <string>

#include "core/base/error.h"

namespace handgraft::session {

void validate(const SolverSettings& solving) {
  if (solving.starts < 1 || solving.starts > kMostStarts) {
    rejectInput("starts: {} is outside 1-{}", solving.starts, kMostStarts);
  }
  if (solving.max_evaluations < 1 || solving.max_evaluations > kMostEvaluations) {
    rejectInput("max_evaluations: {} is outside 1-{}", solving.max_evaluations,
                kMostEvaluations);
  }
  if (!solving.paper) return;
  if (solving.solver != optimize::kDefaultSolver) {
    rejectInput("solver {}: the paper's way has its own, mma",
                quoted(std::string(nameOf(solving.solver))));
  }
  if (solving.starts != optimize::kDefaultStarts) {
    rejectInput("starts: {} do not go with the paper's way, which has one", solving.starts);
  }
}

SolverSettings afterEdit(SolverSettings solving) {
  if (solving.starts == optimize::kDefaultStarts && !solving.paper)
    solving.starts = kStartsAfterEdit;
  return solving;
}

optimize::SolveOptions solveOptions(const SolverSettings& solving) {
  validate(solving);
  optimize::SolveOptions options;
  if (solving.paper) {
    options = optimize::paperOptions();
  } else {
    options.solver = solving.solver;
    options.starts = solving.starts;
  }
  options.seed = solving.seed;
  options.max_evaluations = solving.max_evaluations;
  return options;
}

}  // namespace handgraft::session
