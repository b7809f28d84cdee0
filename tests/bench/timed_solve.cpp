#include "tests/bench/timed_solve.h"

#include <algorithm>
#include <chrono>

#include "core/base/error.h"
#include "core/io/problem_file.h"

namespace handgraft::bench {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

TimedSolve timedSolve(const std::filesystem::path& path, const SolveSettings& settings) {
  constexpr int kMostRepeats = 100000;
  if (settings.repeat < 1 || settings.repeat > kMostRepeats) {
    rejectInput("--repeat: {} must lie in 1 to {}", settings.repeat, kMostRepeats);
  }
  optimize::SolveOptions options;
  options.solver = optimize::solverFrom(settings.solver);
  options.starts = settings.starts;
  options.threads = settings.threads;
  options.seed = settings.seed;

  TimedSolve run;
  const Clock::time_point setup = Clock::now();
  const io::ProblemFile file = io::readProblemFile(path);
  run.ms_setup = millisecondsSince(setup);

  std::vector<double> times;
  for (int i = 0; i < settings.repeat; ++i) {
    const Clock::time_point start = Clock::now();
    run.report = optimize::solve(file.problem, options, Progress());
    times.push_back(millisecondsSince(start));
  }
  std::sort(times.begin(), times.end());
  run.ms_least = times.front();
  run.ms_most = times.back();
  const std::size_t middle = times.size() / 2;
  run.ms_median =
      times.size() % 2 == 1 ? times[middle] : 0.5 * (times[middle - 1] + times[middle]);

  const Eigen::VectorXd theta = io::thetaOf(run.report.pose);
  for (const int dof : file.order)
    run.theta.push_back(theta[dof]);
  return run;
}

}  // namespace handgraft::bench
