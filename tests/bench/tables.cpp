#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/optimize/align_root.h"
#include "core/optimize/moment_tree.h"

#include "tests/bench/grasp_problems.h"
#include "tests/bench/paper_figures.h"
#include "tests/bench/scaling.h"
#include "tests/bench/skin_cache.h"
#include "tests/bench/timed_solve.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

using optimize::PoseProblem;

constexpr int kPlacements = 3;
constexpr int kMostCalls = 20;
constexpr double kWorthACall = 0.01;  // share of the fit that another call has to gain

struct TablesArguments {
  std::string models = "server/models";
  std::string cache = defaultCache().string();
  std::vector<std::string> hands;
  int repeat = 5;
};

/// Where a hand at rest at the world's origin would have its contact points.
struct RestingHand {
  Pose X_WH = Pose::Identity();                    ///< that fits the object best as it lies
  Eigen::Vector3d p_H = Eigen::Vector3d::Zero();   ///< mean of the points, at rest
  Eigen::Vector3d n_H = Eigen::Vector3d::UnitZ();  ///< mean of their normals
};

RestingHand restingHand(const PoseProblem& problem) {
  RestingHand resting;
  resting.X_WH = alignRoot(problem, makeMomentTree(problem), problem.start.q);
  const hand::HandPose rest{Pose::Identity(), problem.start.q};
  const hand::LinkPoses X_HL = forwardKinematics(*problem.model, rest);
  Eigen::Vector3d normals = Eigen::Vector3d::Zero();
  for (const optimize::PointPair& pair : problem.pairs) {
    const Pose& X = X_HL[static_cast<std::size_t>(pair.link)];
    resting.p_H += X * pair.p_L / static_cast<double>(problem.pairs.size());
    normals += X.linear() * pair.n_L;
  }
  if (normals.norm() > 0.0) resting.n_H = normals.normalized();
  return resting;
}

Pose turnedAbout(const Eigen::Vector3d& center, const Eigen::Matrix3d& R) {
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = center - R * center;
  return X;
}

Pose shiftedBy(const Eigen::Vector3d& way) {
  Pose X = Pose::Identity();
  X.translation() = way;
  return X;
}

/// The problem with its object 5 cm before the resting hand, as that would hold it, turned by
/// up to 20 degrees and moved by up to 3 cm; start and prior are the hand at rest at the
/// origin. `poor`: then inverted (half a turn about an axis across the palm) and put 15 cm
/// behind the hand.
PoseProblem placed(const PoseProblem& problem,
                   const RestingHand& resting,
                   int placement,
                   bool poor) {
  constexpr double kBefore = 0.05;  // m
  constexpr double kBehind = 0.15;  // m
  constexpr double kMoved = 0.03;   // m
  constexpr double kTurned = std::numbers::pi / 9.0;
  std::mt19937 random(static_cast<unsigned>(placement + 1));
  const Eigen::Matrix3d turn =
      rotationFromVector(uniform(random, 0.0, kTurned) * randomUnit(random));
  const Eigen::Vector3d way =
      kBefore * resting.n_H + uniform(random, 0.0, kMoved) * randomUnit(random);
  Pose X_WV = shiftedBy(way) * turnedAbout(resting.p_H, turn) * resting.X_WH.inverse();
  if (poor) {
    const Eigen::Vector3d across = randomUnit(random).cross(resting.n_H).normalized();
    const Eigen::Vector3d center = resting.p_H + way;
    X_WV = shiftedBy(resting.p_H - kBehind * resting.n_H - center) *
           turnedAbout(center, rotationFromVector(std::numbers::pi * across)) * X_WV;
  }
  return moved(problem, X_WV);
}

struct Fit {
  double mean_mm = 0.0;
  double normal_deg = 0.0;
};

Fit meanFit(const optimize::SolveReport& report) {
  Fit fit;
  int points = 0;
  for (const optimize::PatchFit& patch : report.patches) {
    fit.mean_mm += patch.mean_mm * patch.point_count;
    fit.normal_deg += patch.normal_mean_deg * patch.point_count;
    points += patch.point_count;
  }
  fit.mean_mm /= std::max(1, points);
  fit.normal_deg /= std::max(1, points);
  return fit;
}

struct PaperRun {
  optimize::SolveReport report;
  int calls = 0;
  double ms = 0.0;
};

/// As the paper's user works, but without edits: solve, let start and prior follow, solve again
/// while that brings something.
PaperRun solveAsThePaper(PoseProblem problem) {
  PaperRun run;
  SolveSettings settings;
  settings.paper = true;
  double before = 0.0;
  do {
    optimize::PoseSolver solver(problem);
    before = run.calls == 0 ? 0.0 : fitOf(problem, run.report.terms);
    const TimedSolve call = timedSolve(solver, settings);
    run.report = call.report;
    run.ms += call.ms_median;
    ++run.calls;
    problem.start = problem.prior = run.report.pose;
  } while (run.calls < kMostCalls &&
           (run.calls == 1 || fitOf(problem, run.report.terms) < (1.0 - kWorthACall) * before));
  return run;
}

/// Means over the placements of one hand, set and kind of start.
struct Cell {
  double ms = 0.0;
  Fit fit;
  double paper_ms = 0.0;
  double paper_calls = 0.0;
  Fit paper_fit;
  int paper_close = 0;
  std::vector<double> fits;  ///< weighted, a placement
};

Cell measure(const PoseProblem& problem,
             const RestingHand& resting,
             bool poor,
             const TablesArguments& arguments) {
  Cell cell;
  SolveSettings settings;
  settings.repeat = arguments.repeat;
  for (int k = 0; k < kPlacements; ++k) {
    const PoseProblem instance = placed(problem, resting, k, poor);
    optimize::PoseSolver solver(instance);
    const TimedSolve ours = timedSolve(solver, settings);
    const PaperRun theirs = solveAsThePaper(instance);
    const Fit fit = meanFit(ours.report);
    const Fit paper_fit = meanFit(theirs.report);
    cell.ms += ours.ms_median / kPlacements;
    cell.fit.mean_mm += fit.mean_mm / kPlacements;
    cell.fit.normal_deg += fit.normal_deg / kPlacements;
    cell.paper_ms += theirs.ms / kPlacements;
    cell.paper_calls += static_cast<double>(theirs.calls) / kPlacements;
    cell.paper_fit.mean_mm += paper_fit.mean_mm / kPlacements;
    cell.paper_fit.normal_deg += paper_fit.normal_deg / kPlacements;
    cell.fits.push_back(fitOf(instance, ours.report.terms));
    cell.paper_close += fitOf(instance, theirs.report.terms) <= 1.01 * cell.fits.back() ? 1 : 0;
  }
  return cell;
}

int patchesOf(const optimize::PoseProblem& problem) {
  std::vector<int> patches;
  for (const optimize::PointPair& pair : problem.pairs)
    patches.push_back(pair.patch);
  std::sort(patches.begin(), patches.end());
  patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  return static_cast<int>(patches.size());
}

std::string figureText(const PaperFigure& figure) {
  if (figure.seconds == 0.0) return "n/a";
  return fmt::format("{:.3f} s / {:g}", figure.seconds, figure.edits);
}

void runTables(const TablesArguments& arguments) {
  constexpr std::array kSets = {std::pair{"scissors", "scissors_3"},
                                std::pair{"wine_glass", "wine_glass_4"},
                                std::pair{"box", "box_5"}, std::pair{"lemon", "lemon_6"}};
  fmt::print(
      "| hand (ours, the paper's) | contacts | patches laid | start | paper: time / edits | "
      "ours: ms / edits | mm | deg | `--paper`: calls | ms | mm | deg | as ours |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  int alike = 0;
  int count = 0;
  double widest = 0.0;
  for (const PaperRow& row : kPaperRows) {
    if (!arguments.hands.empty() && std::find(arguments.hands.begin(), arguments.hands.end(),
                                              row.hand) == arguments.hands.end()) {
      continue;
    }
    const FiledHand hand =
        builtInHand(arguments.models, std::string(row.hand), arguments.cache);
    for (std::size_t column = 0; column < kSets.size(); ++column) {
      // The paper's Barrett hand holds the lemon by four patches, and has no fingers for more.
      const bool barrett = row.hand == "barrett8";
      if (barrett && column > 1) continue;
      const auto& [object, contacts] = kSets[barrett && column == 1 ? 3 : column];
      const ScannedGrasp grasp = builtInGrasp(arguments.models, object, contacts);
      session::Session session(hand.hand, grasp.object_O, grasp.contacts, Pose::Identity(), {});
      session.transferPatches(Progress());
      const PoseProblem problem = session.problem();
      const RestingHand resting = restingHand(problem);
      std::vector<double> favourable;
      for (const bool poor : {false, true}) {
        const Cell cell = measure(problem, resting, poor, arguments);
        fmt::print(
            "| {} ({}), {} | {} | {} | {} | {} | {:.1f} / 0 | {:.2f} | {:.1f} | {:.1f} | "
            "{:.0f} "
            "| {:.2f} | {:.1f} | {} of {} |\n",
            row.hand, problem.dofCount(), row.theirs, contacts, patchesOf(problem),
            poor ? "poor" : "favourable",
            figureText(poor ? row.poor[column] : row.favourable[column]), cell.ms,
            cell.fit.mean_mm, cell.fit.normal_deg, cell.paper_calls, cell.paper_ms,
            cell.paper_fit.mean_mm, cell.paper_fit.normal_deg, cell.paper_close, kPlacements);
        if (!poor) favourable = cell.fits;
        for (std::size_t k = 0; poor && k < favourable.size(); ++k) {
          const double gap =
              std::max(cell.fits[k], favourable[k]) / std::min(cell.fits[k], favourable[k]) -
              1.0;
          widest = std::max(widest, gap);
          alike += gap <= 0.01 ? 1 : 0;
          ++count;
        }
      }
    }
  }
  fmt::print(
      "\nFavourable and poor starts end alike, within 1 % of distance and normals, in {} of "
      "{}; "
      "farthest apart {:.2f} %.\n",
      alike, count, 100.0 * widest);
}

}  // namespace

void addTablesCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "tables", "The paper's Tables I and II: our times beside its own; markdown");
  const auto arguments = std::make_shared<TablesArguments>();
  command->add_option("--models", arguments->models, "Folder of the built-in library")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "Folder that keeps skins")
      ->capture_default_str();
  command->add_option("--hand", arguments->hands, "These alone")
      ->check(CLI::IsMember({"human20", "allegro16", "barrett8", "tendon16"}));
  command->add_option("--repeat", arguments->repeat, "Solves, of which the median time counts")
      ->capture_default_str();
  command->callback([arguments] {
    runTables(*arguments);
  });
}

}  // namespace handgraft::bench
