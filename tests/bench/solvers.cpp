#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/bench/problem_folder.h"
#include "tests/bench/solve.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct SolversArguments {
  std::string directory;
  std::string only;  ///< names, separated by blanks; empty: all
  bool json = false;
  SolveSettings settings;
};

/// Of one solver over all problems.
struct Row {
  std::string solver;
  std::vector<double> gaps;  ///< objective / best known - 1
  std::vector<double> times_ms;
  std::map<std::string, int> outcomes;
  long long evaluations = 0;
};

int countWithin(const Row& row, double gap) {
  return static_cast<int>(std::count_if(row.gaps.begin(), row.gaps.end(), [gap](double g) {
    return g <= gap;
  }));
}

Row measure(const std::string& solver,
            const SolversArguments& arguments,
            const std::map<std::string, double>& best_known) {
  Row row;
  row.solver = solver;
  SolveSettings settings = arguments.settings;
  settings.solver = solver;
  for (const auto& [name, best] : best_known) {
    const TimedSolve run =
        timedSolve(fs::path(arguments.directory) / (name + ".json"), settings);
    row.gaps.push_back(run.report.terms.objective / best - 1.0);
    row.times_ms.push_back(run.ms_median);
    ++row.outcomes[std::string(nameOf(run.report.outcome))];
    row.evaluations += run.report.evaluations;
  }
  return row;
}

void printTable(const std::vector<Row>& rows, const SolveSettings& settings) {
  std::printf("%zu problems, %d starts, %d thread(s), median of %d\n",
              rows.empty() ? 0 : rows.front().gaps.size(), settings.starts, settings.threads,
              settings.repeat);
  std::printf("%-8s %9s %9s %9s %10s %9s %9s %12s\n", "solver", "in 0.1 %", "in 1 %", "worst %",
              "median ms", "least ms", "most ms", "evaluations");
  for (const Row& row : rows) {
    std::printf("%-8s %9d %9d %9.3f %10.2f %9.2f %9.2f %12lld\n", row.solver.c_str(),
                countWithin(row, 0.001), countWithin(row, 0.01),
                100.0 * quantile(row.gaps, 1.0), quantile(row.times_ms, 0.5),
                quantile(row.times_ms, 0.0), quantile(row.times_ms, 1.0),
                row.evaluations / static_cast<long long>(row.gaps.size()));
  }
}

void printJson(const std::vector<Row>& rows, const SolveSettings& settings) {
  for (const Row& row : rows) {
    nlohmann::ordered_json line;
    line["solver"] = row.solver;
    line["problems"] = row.gaps.size();
    line["starts"] = settings.starts;
    line["threads"] = settings.threads;
    line["within_0.1_percent"] = countWithin(row, 0.001);
    line["within_1_percent"] = countWithin(row, 0.01);
    line["worst_gap"] = quantile(row.gaps, 1.0);
    line["ms_median"] = quantile(row.times_ms, 0.5);
    line["ms_least"] = quantile(row.times_ms, 0.0);
    line["ms_most"] = quantile(row.times_ms, 1.0);
    line["evaluations_mean"] = row.evaluations / static_cast<long long>(row.gaps.size());
    line["outcomes"] = row.outcomes;
    std::printf("%s\n", line.dump().c_str());
  }
}

void runSolvers(const SolversArguments& arguments) {
  const std::map<std::string, double> best_known = readBestKnown(arguments.directory);
  std::vector<std::string> solvers;
  std::istringstream names(arguments.only);
  for (std::string name; names >> name;)
    solvers.push_back(name);
  std::vector<Row> rows;
  for (const std::string& solver : solvers) {
    rows.push_back(measure(solver, arguments, best_known));
  }
  if (arguments.json) {
    printJson(rows, arguments.settings);
  } else {
    printTable(rows, arguments.settings);
  }
}

}  // namespace

void addSolversCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "solvers", "All solvers over a folder of problems with a reference.json");
  const auto arguments = std::make_shared<SolversArguments>();
  arguments->only = "lm mma ccsaq slsqp lbfgs tnewton var2";
  command->add_option("directory", arguments->directory, "Problems and their reference.json")
      ->required();
  command->add_option("--solvers", arguments->only, "Names, separated by blanks")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "One JSON line a solver instead of a table");
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runSolvers(*arguments);
  });
}

}  // namespace handgraft::bench
