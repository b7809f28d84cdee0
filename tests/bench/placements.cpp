#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/problem_file.h"

#include "tests/bench/grasp_problems.h"
#include "tests/bench/problem_folder.h"
#include "tests/bench/scaling.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct PlacementsArguments {
  std::string directory;
  int placements = 100;
  SolveSettings settings;
};

/// The object turned by half a turn (the first) or anyhow and put up to half a metre off, seen
/// from the hand, whose start and prior stay what they are.
optimize::PoseProblem displaced(const optimize::PoseProblem& problem,
                                int placement,
                                std::mt19937& random) {
  const double angle =
      placement == 0 ? std::numbers::pi : uniform(random, 0.0, std::numbers::pi);
  Pose X_WV = Pose::Identity();
  X_WV.linear() = rotationFromVector(angle * randomUnit(random));
  X_WV.translation() = uniform(random, 0.3, 0.5) * randomUnit(random);
  return moved(problem, X_WV);
}

void runPlacements(const PlacementsArguments& arguments) {
  int solved = 0;
  int solved_fit = 0;
  int count = 0;
  double worst = 0.0;
  std::vector<double> times;
  std::vector<std::string> misses;
  for (const auto& [name, best] : readBestKnown(arguments.directory)) {
    if (name.find("_fav") == std::string::npos) continue;
    std::mt19937 random(1);
    const optimize::PoseProblem favourable =
        io::readProblem(fs::path(arguments.directory) / (name + ".json"));
    optimize::PoseSolver solver(favourable);
    const optimize::SolveReport wanted = timedSolve(solver, arguments.settings).report;
    int missed = 0;
    for (int k = 0; k < arguments.placements; ++k) {
      optimize::PoseSolver poor(displaced(favourable, k, random));
      const TimedSolve run = timedSolve(poor, arguments.settings);
      const double gap = run.report.terms.objective / wanted.terms.objective - 1.0;
      const double fit_gap =
          fitOf(poor.problem(), run.report.terms) / fitOf(favourable, wanted.terms) - 1.0;
      times.push_back(run.ms_median);
      worst = std::max(worst, gap);
      ++count;
      solved += gap <= 0.01 ? 1 : 0;
      solved_fit += fit_gap <= 0.01 ? 1 : 0;
      missed += gap > 0.01 ? 1 : 0;
    }
    if (missed > 0) misses.push_back(name + ": " + std::to_string(missed));
  }
  std::printf(
      "%d poor placements: %d (%.2f %%) within 1 %% of the favourable start, %d (%.2f %%) by "
      "distance and normals alone; worst %+.2f %%; ms %.2f (p50) %.2f (p95)\n",
      count, solved, 100.0 * solved / count, solved_fit, 100.0 * solved_fit / count,
      100.0 * worst, quantile(times, 0.5), quantile(times, 0.95));
  for (const std::string& miss : misses)
    std::printf("missed %s of %d\n", miss.c_str(), arguments.placements);
}

}  // namespace

void addPlacementsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "placements",
      "Problems with the object turned and put elsewhere, beside their favourable start");
  const auto arguments = std::make_shared<PlacementsArguments>();
  command->add_option("directory", arguments->directory, "Problems and their reference.json")
      ->required();
  command->add_option("--placements", arguments->placements, "Of each problem")
      ->capture_default_str();
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runPlacements(*arguments);
  });
}

}  // namespace handgraft::bench
