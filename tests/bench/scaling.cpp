#include "tests/bench/scaling.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/io/problem_file.h"

#include "tests/bench/problem_folder.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct ScalingArguments {
  std::string directory;
  SolveSettings settings;
};

double uniform(std::mt19937& random) {
  return static_cast<double>(random()) / 4294967296.0;
}

/// A step of up to 1 mm along the surface.
Eigen::Vector3d along(const Eigen::Vector3d& normal, std::mt19937& random) {
  const Eigen::Vector3d step(uniform(random) - 0.5, uniform(random) - 0.5,
                             uniform(random) - 0.5);
  return 2e-3 * (step - step.dot(normal) / normal.squaredNorm() * normal);
}

/// `count` points in place of the problem's, strewn about them; together they weigh as much.
optimize::PoseProblem withPoints(const optimize::PoseProblem& problem, int count) {
  std::mt19937 random(1);
  optimize::PoseProblem result = problem;
  result.pairs.clear();
  const double pairs = static_cast<double>(problem.pairs.size());
  for (int i = 0; i < count; ++i) {
    // Fewer points than pairs are spread evenly over them.
    const double at = count < pairs ? i * pairs / count : std::fmod(i, pairs);
    optimize::PointPair pair = problem.pairs[static_cast<std::size_t>(at)];
    pair.p_L += along(pair.n_L, random);
    pair.p_W += along(pair.n_W, random);
    pair.weight *= pairs / count;
    result.pairs.push_back(pair);
  }
  return result;
}

void runScaling(const ScalingArguments& arguments) {
  const auto problems = readBestKnown(arguments.directory);
  std::printf(
      "%zu problems, %d start(s), median of %d; medians over problems\n\n"
      "| points | ms_setup | ms_median | us an evaluation | ms_report "
      "|\n|---|---|---|---|---|\n",
      problems.size(), arguments.settings.starts, arguments.settings.repeat);
  for (const int count : {10, 100, 1000, 10000}) {
    std::vector<double> setups;
    std::vector<double> times;
    std::vector<double> each;
    std::vector<double> reports;
    for (const auto& [name, best] : problems) {
      const optimize::PoseProblem problem =
          withPoints(io::readProblem(fs::path(arguments.directory) / (name + ".json")), count);
      const double setup = threadMilliseconds();
      optimize::PoseSolver solver(problem);
      setups.push_back(threadMilliseconds() - setup);
      const TimedSolve run = timedSolve(solver, arguments.settings);
      times.push_back(run.ms_median);
      each.push_back(1e3 * run.ms_median / run.report.evaluations);
      reports.push_back(run.ms_report);
    }
    std::printf("| %d | %.3f | %.4f | %.2f | %.3f |\n", count, quantile(setups, 0.5),
                quantile(times, 0.5), quantile(each, 0.5), quantile(reports, 0.5));
  }
}

}  // namespace

void addScalingCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("scaling", "Time of a solve with 10 to 10,000 points; markdown");
  const auto arguments = std::make_shared<ScalingArguments>();
  arguments->settings.repeat = 21;
  arguments->settings.starts = 2;
  command->add_option("directory", arguments->directory, "Problems and their reference.json")
      ->required();
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runScaling(*arguments);
  });
}

}  // namespace handgraft::bench
