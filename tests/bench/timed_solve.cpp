#include "tests/bench/timed_solve.h"

#include <chrono>

#include "core/base/error.h"
#include "core/io/problem_file.h"

#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

using Clock = std::chrono::steady_clock;

double wallMilliseconds() {
  return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
}

}  // namespace

optimize::SolveOptions optionsOf(const SolveSettings& settings) {
  constexpr int kMostRepeats = 100000;
  if (settings.repeat < 1 || settings.repeat > kMostRepeats) {
    rejectInput("--repeat: {} must lie in 1 to {}", settings.repeat, kMostRepeats);
  }
  optimize::SolveOptions options;
  if (settings.paper) options = optimize::paperOptions();
  if (!settings.paper) {
    options.solver = optimize::solverFrom(settings.solver);
    options.starts = settings.starts;
  }
  options.threads = settings.threads;
  options.seed = settings.seed;
  return options;
}

TimedSolve timedSolve(optimize::PoseSolver& solver, const SolveSettings& settings) {
  const optimize::SolveOptions options = optionsOf(settings);
  const auto now = settings.threads == 1 ? threadMilliseconds : wallMilliseconds;
  TimedSolve run;
  std::vector<double> times;
  for (int i = 0; i < settings.repeat; ++i) {
    const double start = now();
    run.report = solver.search(options, Progress());
    times.push_back(now() - start);
  }
  run.ms_least = quantile(times, 0.0);
  run.ms_median = quantile(times, 0.5);
  run.ms_most = quantile(times, 1.0);
  const double judging = now();
  judge(solver.problem(), run.report);
  run.ms_report = now() - judging;
  return run;
}

TimedSolve timedSolve(const std::filesystem::path& path, const SolveSettings& settings) {
  const double setup = threadMilliseconds();
  const io::ProblemFile file = io::readProblemFile(path);
  optimize::PoseSolver solver(file.problem);
  const double ms_setup = threadMilliseconds() - setup;
  TimedSolve run = timedSolve(solver, settings);
  run.ms_setup = ms_setup;
  const Eigen::VectorXd theta = io::thetaOf(run.report.pose);
  for (const int dof : file.order)
    run.theta.push_back(theta[dof]);
  return run;
}

}  // namespace handgraft::bench
