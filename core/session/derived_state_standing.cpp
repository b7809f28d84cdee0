// The pose as it stands: judged without a search, and kept where one finds nothing better.
#include <utility>
#include <vector>

#include "core/optimize/minima.h"
#include "core/placement/solids.h"
#include "core/session/derived_state.h"

namespace handgraft::session {

Solution DerivedState::judge(const Progress& progress) {
  return judgeBy(document_.solving, progress);
}

Solution DerivedState::judgeBy(const SolverSettings& solving, const Progress& progress) {
  transfer(progress);
  requirePoints();
  if (solving.avoids()) placement::makeSolids(*models_.hand, models_.object_O, progress);
  Solution solution;
  solution.solving = solving;
  solution.problem = problem(solving);
  solution.document = document_;
  solution.patches = patches_;
  optimize::SolveReport& report = solution.report;
  report.outcome =
      document_.is_solved ? optimize::Outcome::kConverged : optimize::Outcome::kStalled;
  report.solver = "standing";
  report.pose = solution.problem.start;
  optimize::validate(solution.problem);
  optimize::judge(solution.problem, report);
  optimize::Minimum only;
  only.pose = report.pose;
  only.terms = report.terms;
  only.outcome = report.outcome;
  only.solver = report.solver;
  report.minima = {only};
  return solution;
}

Solution DerivedState::keptInsteadOf(Solution found, Solution standing) const {
  optimize::SolveReport& report = standing.report;
  std::vector<optimize::Minimum> minima = std::move(found.report.minima);
  minima.push_back(report.minima.front());
  minima.back().solver = found.report.solver;
  optimize::rankMinima(*models_.hand->model, {}, "", minima);
  report.minima = std::move(minima);
  report.solver = found.report.solver;
  report.starts = found.report.starts;
  report.best_start = found.report.best_start;
  report.evaluations = found.report.evaluations;
  return standing;
}

}  // namespace handgraft::session
