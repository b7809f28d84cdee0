#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/problem_file.h"

#include "tests/bench/grasp_problems.h"
#include "tests/bench/scaling.h"
#include "tests/bench/skin_cache.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct PairsArguments {
  std::string models = "server/models";
  std::string out;
  std::vector<std::string> hands;
  std::string cache = defaultCache().string();
  int placements = 3;
  int reference = 0;
  SolveSettings settings;
};

struct ExportedPair {
  fs::path file;
  int dofs = 0;  ///< the root's six included
};

/// The object anywhere within 0.4 m, however turned.
Pose anyPlacement(std::mt19937& random) {
  Pose X_WO = Pose::Identity();
  X_WO.linear() =
      rotationFromVector(uniform(random, 0.0, std::numbers::pi) * randomUnit(random));
  X_WO.translation() = uniform(random, 0.0, 0.4) * randomUnit(random);
  return X_WO;
}

/// Opens a session a hand and grasp, lays the patches for each placement and writes what would
/// be solved. Pairs that are refused are told.
std::vector<ExportedPair> exportPairs(const PairsArguments& arguments) {
  const std::vector<FiledHand> hands =
      measuredHands(arguments.models, arguments.cache, arguments.hands);
  const std::vector<ScannedGrasp> grasps = measuredGrasps(arguments.models);
  fs::create_directories(arguments.out);
  std::mt19937 random(1);
  std::vector<ExportedPair> pairs;
  for (const FiledHand& hand : hands) {
    for (const ScannedGrasp& grasp : grasps) {
      for (int k = 0; k < arguments.placements; ++k) {
        const Pose X_WO = anyPlacement(random);
        try {
          session::Session session(hand.hand, grasp.object_O, grasp.contacts, X_WO, {});
          session.transferPatches(Progress());
          const optimize::PoseProblem problem = session.problem();
          std::string name = fmt::format("{}_{}_{}.json", hand.name, grasp.name, k);
          std::replace(name.begin(), name.end(), ' ', '_');
          const fs::path file = fs::path(arguments.out) / name;
          std::ofstream(file, std::ios::binary)
              << io::problemText(problem, hand.urdf.string(), {});
          pairs.push_back({file, problem.dofCount()});
        } catch (const InvalidInput& refusal) {
          fmt::print(stderr, "{} and {}: {}\n", hand.name, grasp.name, refusal.what());
          break;
        }
      }
    }
  }
  return pairs;
}

struct Group {
  std::vector<double> own_ms;
  std::vector<double> aligned_ms;
  std::vector<double> all_ms;
  int close = 0;
  double worst = 0.0;
};

void measure(const ExportedPair& pair, const PairsArguments& arguments, Group& group) {
  optimize::PoseSolver solver(io::readProblem(pair.file));
  SolveSettings settings = arguments.settings;
  settings.starts = 1;
  group.own_ms.push_back(timedSolve(solver, settings).ms_median);
  settings.starts = 2;
  group.aligned_ms.push_back(timedSolve(solver, settings).ms_median - group.own_ms.back());
  const TimedSolve run = timedSolve(solver, arguments.settings);
  group.all_ms.push_back(run.ms_median);
  if (arguments.reference == 0) return;
  settings.starts = arguments.reference;
  settings.seed = 12345;
  settings.repeat = 1;
  const double best =
      std::min(timedSolve(solver, settings).report.terms.objective, run.report.terms.objective);
  const double gap = run.report.terms.objective / best - 1.0;
  group.worst = std::max(group.worst, gap);
  group.close += gap <= 0.01 ? 1 : 0;
  if (gap > 0.01) fmt::print(stderr, "{}: {:.2f} % above\n", pair.file.string(), 100.0 * gap);
}

void runPairs(const PairsArguments& arguments) {
  std::map<int, Group> groups;
  const std::vector<ExportedPair> pairs = exportPairs(arguments);
  for (const ExportedPair& pair : pairs)
    measure(pair, arguments, groups[pair.dofs]);
  fmt::print(
      "{} pairs of hand and contacts, {} object placements each, written to {} and read again; "
      "processor time, median of {}\n\n"
      "| dofs | pairs | ms, own start | most | ms, a closed-form start | ms, {} starts | most "
      "| in 1 % | worst |\n|---|---|---|---|---|---|---|---|---|\n",
      pairs.size(), arguments.placements, arguments.out, arguments.settings.repeat,
      arguments.settings.starts);
  for (const auto& [dofs, group] : groups) {
    const bool compared = arguments.reference > 0;
    fmt::print("| {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | {:.2f} | {} | {} |\n", dofs,
               group.own_ms.size(), quantile(group.own_ms, 0.5), quantile(group.own_ms, 1.0),
               quantile(group.aligned_ms, 0.5), quantile(group.all_ms, 0.5),
               quantile(group.all_ms, 1.0), compared ? fmt::format("{}", group.close) : "",
               compared ? fmt::format("{:.2f} %", 100.0 * group.worst) : "");
  }
}

}  // namespace

void addPairsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "pairs",
      "Writes the problems of many hands and contacts, and solves them from the files");
  const auto arguments = std::make_shared<PairsArguments>();
  arguments->settings.repeat = 5;
  command->add_option("out", arguments->out, "Folder for the problem files")->required();
  command->add_option("--models", arguments->models, "Folder of the built-in library")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "Folder that keeps skins")
      ->capture_default_str();
  command->add_option("--hand", arguments->hands, "Built-in ones, in place of all")
      ->check(CLI::IsMember({"human20", "allegro16", "barrett8", "tendon16"}));
  command->add_option("--placements", arguments->placements, "Of each object")
      ->capture_default_str();
  command->add_option("--reference", arguments->reference,
                      "Starts of a solve to compare with; 0: none");
  addSettings(*command, arguments->settings);
  command->callback([arguments] {
    runPairs(*arguments);
  });
}

}  // namespace handgraft::bench
