#include "tests/bench/solve.h"

#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "core/base/error.h"

#include "tests/bench/timed_solve.h"

namespace handgraft::bench {

namespace {

struct SolveArguments {
  std::string path;
  SolveSettings settings;
};

void runSolve(const SolveArguments& arguments) {
  const TimedSolve run = timedSolve(arguments.path, arguments.settings);
  nlohmann::ordered_json line;
  line["objective"] = run.report.terms.objective;
  line["distance"] = run.report.terms.distance;
  line["normal"] = run.report.terms.normal;
  line["prior"] = run.report.terms.prior;
  line["theta"] = run.theta;
  line["ms_setup"] = run.ms_setup;
  line["ms_median"] = run.ms_median;
  line["evaluations"] = run.report.evaluations;
  line["outcome"] = optimize::nameOf(run.report.outcome);
  line["solver"] = run.report.solver;
  std::printf("%s\n", line.dump().c_str());
}

}  // namespace

void addSettings(CLI::App& command, SolveSettings& settings) {
  command.add_option("--starts", settings.starts, "Starting poses")->capture_default_str();
  command.add_option("--repeat", settings.repeat, "Solves, of which the median time counts")
      ->capture_default_str();
  command.add_option("--threads", settings.threads, "Threads that share the starts")
      ->capture_default_str();
  command.add_option("--seed", settings.seed, "Seed of the starting joints")
      ->capture_default_str();
}

void addSolveCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("solve", "Solve one problem file; one JSON line");
  const auto arguments = std::make_shared<SolveArguments>();
  command->add_option("problem", arguments->path, "A handgraft-problem/1 file")->required();
  command
      ->add_option("--solver", arguments->settings.solver, "mma ccsaq slsqp lbfgs tnewton var2")
      ->capture_default_str();
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runSolve(*arguments);
  });
}

}  // namespace handgraft::bench
