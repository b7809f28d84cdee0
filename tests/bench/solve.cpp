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
  line["ms_report"] = run.ms_report;
  line["evaluations"] = run.report.evaluations;
  line["outcome"] = optimize::nameOf(run.report.outcome);
  line["solver"] = run.report.solver;
  line["best_start"] = run.report.best_start;
  line["minima"] = nlohmann::json::array();
  for (const optimize::Minimum& minimum : run.report.minima) {
    line["minima"].push_back({{"objective", minimum.terms.objective},
                              {"solver", minimum.solver},
                              {"start", minimum.start},
                              {"hits", minimum.hits}});
  }
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
      ->add_option("--solver", arguments->settings.solver,
                   "lm mma ccsaq slsqp lbfgs tnewton var2, or all")
      ->capture_default_str();
  addSettings(*command, arguments->settings);
  command->add_flag("--paper", arguments->settings.paper, "One start from the prior, MMA");
  command->callback([arguments] {
    runSolve(*arguments);
  });
}

}  // namespace handgraft::bench
