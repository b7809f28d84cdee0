#include "core/optimize/avoidance_repair.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/optimize/local_search.h"
#include "core/optimize/minima.h"
#include "core/optimize/pose_solver.h"

namespace handgraft::optimize {

namespace {

// Evaluations of each minimum, and of the best of them. Near a kink of the distance field,
// where two walls are equally near, a search creeps without end.
constexpr int kExploring = 25;
constexpr int kFinishing = 200;
constexpr std::size_t kFinishers = 2;

}  // namespace

SolveReport solveAvoiding(const PoseProblem& problem,
                          const SolveOptions& options,
                          const Progress& progress) {
  HANDGRAFT_REQUIRE(problem.avoidance != nullptr);
  PoseProblem contacts = problem;
  contacts.avoidance = nullptr;
  // Poses on the way there lie where they may not stay.
  SolveOptions quiet = options;
  quiet.on_improvement = nullptr;
  SolveReport report = PoseSolver(std::move(contacts)).search(quiet, progress);
  PoseSolver judge(problem);
  if (report.outcome == Outcome::kInfeasible) {
    judge.judge(report);
    return report;
  }

  const PreparedProblem prepared(problem);
  LocalSearch search(prepared);
  double best = std::numeric_limits<double>::infinity();
  const LocalSearch::Observer observer = [&](const hand::HandPose& pose, const Terms& terms) {
    if (terms.objective >= best) return;
    best = terms.objective;
    options.on_improvement(pose, terms);
  };
  const std::function<void()> keep_going = [&progress] {
    progress.checkpoint();
  };
  const LocalSearch::Observer none;
  search.attend(options.on_improvement ? observer : none, keep_going);

  const std::vector<Minimum> found = std::move(report.minima);
  report.minima.clear();
  // By solver, as they rank what they found.
  for (const Solver solver : singleSolvers()) {
    std::vector<LocalResult> results;
    std::vector<int> starts;
    const auto begin = [&](const hand::HandPose& start, int number) {
      results.push_back(search.begin(start));
      search.advance(solver, std::min(kExploring, options.max_evaluations) - 1, results.back());
      starts.push_back(number);
    };
    for (const Minimum& minimum : found)
      if (minimum.solver == nameOf(solver)) begin(minimum.pose, minimum.start);
    if (options.solver == solver) begin(problem.start, 0);
    if (results.empty()) continue;

    std::vector<LocalResult*> order;
    for (LocalResult& result : results)
      order.push_back(&result);
    std::stable_sort(order.begin(), order.end(),
                     [](const LocalResult* a, const LocalResult* b) {
                       return a->terms.objective < b->terms.objective;
                     });
    order.resize(std::min(order.size(), kFinishers));
    const int most = std::min(kFinishing, options.max_evaluations);
    for (LocalResult* result : order) {
      if (result->outcome == Outcome::kEvaluationLimit && result->evaluations < most)
        search.advance(solver, most - result->evaluations, *result);
    }
    std::vector<Minimum> ranked;
    rankMinima(*problem.model, results, std::string(nameOf(solver)), ranked);
    for (Minimum& minimum : ranked) {
      minimum.start = starts[static_cast<std::size_t>(minimum.start)];
      report.minima.push_back(std::move(minimum));
    }
    for (const LocalResult& result : results)
      report.evaluations += result.evaluations;
  }
  // Among several solvers, by what they came to.
  rankMinima(*problem.model, {}, "", report.minima);
  const Minimum& answer = report.minima.front();
  report.outcome = answer.outcome;
  report.solver = answer.solver;
  report.pose = answer.pose;
  report.best_start = answer.start;
  judge.judge(report);
  return report;
}

}  // namespace handgraft::optimize
