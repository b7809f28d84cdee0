#include "tests/bench/baseline.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/io/problem_file.h"
#include "core/optimize/solve_report.h"

#include "tests/bench/dart_baseline.h"
#include "tests/bench/problem_folder.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct BaselineArguments {
  std::string directory;
  double tolerance = 1e-8;
  SolveSettings settings;
  int few = 2;
};

struct Entry {
  double objective = 0.0;
  double ms = 0.0;
};

/// One problem solved by all.
struct Line {
  std::string name;
  double best_known = 0.0;
  Entry mma;
  Entry slsqp;
  Entry one;      ///< ours from the problem's own start, as theirs
  Entry aligned;  ///< ours from the closed-form root alone
  Entry few;      ///< ours from that and the closed-form start
  Entry many;     ///< ours as it is by default
};

Entry ours(optimize::PoseSolver& solver, SolveSettings settings, int starts) {
  settings.starts = starts;
  const TimedSolve run = timedSolve(solver, settings);
  return {run.report.terms.objective, run.ms_median};
}

/// The closed form counts, the moments do not: they are made once a problem.
Entry oursAligned(const optimize::PoseProblem& problem, const SolveSettings& settings) {
  optimize::PoseProblem aligned = problem;
  const optimize::MomentTree tree = optimize::makeMomentTree(problem);
  const double ms = leastMilliseconds(settings.repeat, [&] {
    aligned.start.X_WH = optimize::alignRoot(problem, tree, problem.start.q);
  });
  optimize::PoseSolver solver(aligned);
  Entry entry = ours(solver, settings, 1);
  entry.ms += ms;
  return entry;
}

Line measure(const BaselineArguments& arguments, const std::string& name, double best_known) {
  const fs::path path = fs::path(arguments.directory) / (name + ".json");
  optimize::PoseSolver solver(io::readProblem(path));
  DartBaseline dart(solver.problem(), urdfOf(path));
  const auto theirs = [&](BaselineSolver which) -> Entry {
    const BaselineRun run = dart.solve(which, arguments.tolerance);
    return {optimize::sumOverPoints(solver.problem(), run.pose).objective, run.ms};
  };
  Line line;
  line.name = name;
  line.best_known = best_known;
  line.mma = theirs(BaselineSolver::kMma);
  line.slsqp = theirs(BaselineSolver::kSlsqp);
  line.one = ours(solver, arguments.settings, 1);
  line.aligned = oursAligned(solver.problem(), arguments.settings);
  line.few = ours(solver, arguments.settings, arguments.few);
  line.many = ours(solver, arguments.settings, arguments.settings.starts);
  return line;
}

using Member = Entry Line::*;

/// Medians, and how often `which` is as good as the two baselines and as the best known.
void printSummary(const char* title, Member which, const std::vector<Line>& lines) {
  // What two solvers that stop at the same minimum may differ by.
  constexpr double kSame = 1e-4;
  std::vector<double> times;
  std::vector<double> faster_mma;
  std::vector<double> faster_slsqp;
  int as_mma = 0;
  int as_slsqp = 0;
  int within = 0;
  for (const Line& line : lines) {
    const Entry& entry = line.*which;
    times.push_back(entry.ms);
    faster_mma.push_back(line.mma.ms / entry.ms);
    faster_slsqp.push_back(line.slsqp.ms / entry.ms);
    as_mma += entry.objective <= line.mma.objective * (1.0 + kSame) ? 1 : 0;
    as_slsqp += entry.objective <= line.slsqp.objective * (1.0 + kSame) ? 1 : 0;
    within += entry.objective <= line.best_known * 1.01 ? 1 : 0;
  }
  std::printf("| %s | %.3f | %.3f-%.3f | %.1f | %.1f | %d | %d | %d |\n", title,
              quantile(times, 0.5), quantile(times, 0.0), quantile(times, 1.0),
              quantile(faster_mma, 0.5), quantile(faster_slsqp, 0.5), as_mma, as_slsqp, within);
}

void runBaseline(const BaselineArguments& arguments) {
  std::vector<Line> lines;
  for (const auto& [name, best_known] : readBestKnown(arguments.directory))
    lines.push_back(measure(arguments, name, best_known));

  std::printf(
      "| problem | best known | MMA | ms | SLSQP | ms | lm, own | ms | lm, aligned | ms | lm, "
      "%d | ms | lm, "
      "%d | ms |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      arguments.few, arguments.settings.starts);
  for (const Line& line : lines) {
    std::printf("| %s | %.3f |", line.name.c_str(), line.best_known);
    for (const Entry& entry :
         {line.mma, line.slsqp, line.one, line.aligned, line.few, line.many})
      std::printf(" %+.2f %% | %.3f |", 100.0 * (entry.objective / line.best_known - 1.0),
                  entry.ms);
    std::printf("\n");
  }
  std::printf(
      "\n| %zu problems | median ms | least-most ms | x MMA | x SLSQP | as MMA | as SLSQP | "
      "in 1 %% |\n|---|---|---|---|---|---|---|---|\n",
      lines.size());
  printSummary("DART + MMA", &Line::mma, lines);
  printSummary("DART + SLSQP", &Line::slsqp, lines);
  printSummary("lm, own start", &Line::one, lines);
  printSummary("lm, closed-form start", &Line::aligned, lines);
  const std::string few = "lm, " + std::to_string(arguments.few) + " starts";
  const std::string many = "lm, " + std::to_string(arguments.settings.starts) + " starts";
  printSummary(few.c_str(), &Line::few, lines);
  printSummary(many.c_str(), &Line::many, lines);
}

}  // namespace

void addBaselineCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "baseline", "Ours beside the paper's stack (DART, NLopt, numerical gradients); markdown");
  const auto arguments = std::make_shared<BaselineArguments>();
  arguments->settings.repeat = 5;
  command->add_option("directory", arguments->directory, "Problems and their reference.json")
      ->required();
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "Relative change of the objective at which the baseline stops")
      ->capture_default_str();
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runBaseline(*arguments);
  });
}

}  // namespace handgraft::bench
