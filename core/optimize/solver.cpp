#include "core/optimize/solver.h"

#include <array>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/avoiding_solve.h"
#include "core/optimize/pose_solver.h"

namespace handgraft::optimize {

namespace {

constexpr std::array<std::pair<Solver, std::string_view>, 8> kSolverNames = {{
    {Solver::kLm, "lm"},
    {Solver::kMma, "mma"},
    {Solver::kCcsaq, "ccsaq"},
    {Solver::kSlsqp, "slsqp"},
    {Solver::kLbfgs, "lbfgs"},
    {Solver::kTnewton, "tnewton"},
    {Solver::kVar2, "var2"},
    {Solver::kAll, "all"},
}};

}  // namespace

Solver solverFrom(std::string_view name) {
  for (const auto& [solver, known] : kSolverNames) {
    if (known == name) return solver;
  }
  rejectInput(
      "solver {} is not known; permitted: lm mma ccsaq slsqp lbfgs tnewton var2, or all",
      quoted(std::string(name)));
}

std::string_view nameOf(Solver solver) {
  for (const auto& [known, name] : kSolverNames) {
    if (known == solver) return name;
  }
  HANDGRAFT_REQUIRE(false && "a solver of the list");
  return {};
}

std::vector<Solver> singleSolvers() {
  std::vector<Solver> solvers;
  for (const auto& [solver, name] : kSolverNames) {
    if (solver != Solver::kAll) solvers.push_back(solver);
  }
  return solvers;
}

SolveOptions paperOptions() {
  SolveOptions options;
  options.solver = Solver::kMma;
  options.starts = 1;
  options.from_prior = true;
  return options;
}

SolveReport solve(const PoseProblem& problem,
                  const SolveOptions& options,
                  const Progress& progress) {
  if (problem.avoidance != nullptr) {
    return solveAvoiding(problem, options, progress);
  }
  PoseSolver solver(problem);
  SolveReport report = solver.search(options, progress);
  if (report.outcome == Outcome::kInfeasible) {
    judge(problem, report);
  } else {
    judge(problem, report.terms, report);
  }
  return report;
}

}  // namespace handgraft::optimize
