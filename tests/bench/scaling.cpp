#include "tests/bench/scaling.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/io/problem_file.h"

#include "tests/bench/grasp_problems.h"
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

/// A step of up to 1 mm along the surface.
Eigen::Vector3d along(const Eigen::Vector3d& normal, std::mt19937& random) {
  const auto part = [&random] {
    return uniform(random, -0.5, 0.5);
  };
  const double x = part();
  const double y = part();
  const Eigen::Vector3d step(x, y, part());
  return 2e-3 * (step - step.dot(normal) / normal.squaredNorm() * normal);
}

/// How many of `count` points each group gets: one at least, the others by size, so that they
/// are `count` together unless there are more groups.
std::vector<int> shared(int count, const std::vector<std::size_t>& sizes) {
  std::vector<int> shares(sizes.size(), 1);
  for (int left = count - static_cast<int>(sizes.size()); left > 0; --left) {
    // Who has fewest for its size is next.
    std::size_t next = 0;
    for (std::size_t k = 1; k < sizes.size(); ++k) {
      if (static_cast<double>(sizes[k]) * shares[next] >
          static_cast<double>(sizes[next]) * shares[k])
        next = k;
    }
    ++shares[next];
  }
  return shares;
}

/// `count` points in place of the problem's, strewn about them. Each link that has points keeps
/// some, which together weigh as much: a body without points would make the rest cheaper.
optimize::PoseProblem withPoints(const optimize::PoseProblem& problem, int count) {
  std::mt19937 random(1);
  std::map<int, std::vector<optimize::PointPair>> links;
  for (const optimize::PointPair& pair : problem.pairs)
    links[pair.link].push_back(pair);
  std::vector<std::size_t> sizes;
  for (const auto& [link, pairs] : links)
    sizes.push_back(pairs.size());
  const std::vector<int> shares = shared(count, sizes);

  optimize::PoseProblem result = problem;
  result.pairs.clear();
  std::size_t group = 0;
  for (const auto& [link, pairs] : links) {
    const int share = shares[group++];
    const double size = static_cast<double>(pairs.size());
    for (int i = 0; i < share; ++i) {
      // Fewer points than pairs are spread evenly over them.
      const double at = share < size ? i * size / share : std::fmod(i, size);
      optimize::PointPair pair = pairs[static_cast<std::size_t>(at)];
      pair.p_L += along(pair.n_L, random);
      pair.p_W += along(pair.n_W, random);
      pair.weight *= size / share;
      result.pairs.push_back(pair);
    }
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
