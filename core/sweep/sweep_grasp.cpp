#include "core/sweep/sweep_grasp.h"

#include <utility>

#include "core/base/error.h"
#include "core/optimize/solver.h"
#include "core/sweep/sweep_places.h"
#include "core/transfer/staged_transfer.h"

namespace handgraft::sweep {
namespace {

using optimize::PointPair;

constexpr double kSmallGain = 0.01;  // of the objective: as good as none

void append(const std::vector<transfer::Correspondence>& correspondences,
            int patch,
            std::vector<PointPair>& pairs) {
  for (const transfer::Correspondence& one : correspondences) {
    PointPair pair;
    pair.link = one.link;
    pair.p_L = one.p_L;
    pair.n_L = one.n_L;
    pair.p_W = one.p_O;  // the object's frame is the world
    pair.n_W = one.n_O;
    pair.weight = one.weight;
    pair.patch = patch;
    pairs.push_back(pair);
  }
}

}  // namespace

session::Solution solveAnew(const hand::Hand& hand,
                            const SweepGrasp& grasp,
                            const SweepOptions& options,
                            int threads,
                            const Progress& progress,
                            std::vector<std::string>* notes) {
  session::Session session(hand, grasp.object_O, grasp.contacts, Pose::Identity(),
                           options.weights, options.transfer);
  if (notes != nullptr) *notes = session.notes();
  session::SolveRun run;
  run.threads = threads;
  return session.solve(options.solving, run, progress);
}

SweepBase solveBase(const hand::Hand& hand,
                    const SweepGrasp& grasp,
                    const SweepOptions& options,
                    int threads,
                    const Progress& progress) {
  SweepBase base;
  try {
    session::Solution solution =
        solveAnew(hand, grasp, options, threads, progress, &base.notes);
    base.solved = solution.report.pose;
    base.patches = std::move(solution.patches);
    base.prior = solution.problem.prior;
    base.prior_weights = solution.problem.prior_weights;
    for (const session::SessionPatch& item : base.patches) {
      if (!item.placement) continue;
      const auto& chart = item.stages.patchChart();
      base.object_O = {chart, &chart->object()};
    }
  } catch (const InvalidInput& error) {
    base.error = error.what();
  }
  return base;
}

TransferredGrasp layGrasp(const SweepBase& base,
                          const hand::Skin& original,
                          const transfer::Surfaces* bent,
                          const transfer::TransferOptions& options,
                          const Progress& progress) {
  TransferredGrasp laid;
  laid.error = base.error;
  if (!base.error.empty()) return laid;
  try {
    for (std::size_t i = 0; i < base.patches.size(); ++i) {
      const session::SessionPatch& item = base.patches[i];
      if (!item.placement) continue;
      progress.checkpoint();
      if (bent == nullptr) {
        append(item.transferred.correspondences, static_cast<int>(i), laid.pairs);
        continue;
      }
      transfer::StagedTransfer stages = item.stages;  // with the object's chart
      transfer::Surfaces surfaces = *bent;
      surfaces.object_O = base.object_O;
      append(stages
                 .lay(surfaces, item.patch,
                      carriedAlong(original, *bent->skin, *item.placement), options)
                 .correspondences,
             static_cast<int>(i), laid.pairs);
    }
  } catch (const InvalidInput& error) {
    laid.error = error.what();
  }
  return laid;
}

session::Solution solveKept(const SweepBase& base,
                            const TransferredGrasp& laid,
                            const hand::HandVariant& variant,
                            const std::shared_ptr<const optimize::Avoidance>& solids,
                            const SweepOptions& options,
                            const Progress& progress) {
  if (laid.pairs.empty()) rejectInput("no patch has a point on the hand");
  session::Solution solution;
  optimize::PoseProblem& problem = solution.problem;
  problem = optimize::makeProblem(std::make_shared<const hand::HandModel>(variant.model));
  problem.pairs = laid.pairs;
  problem.weights = options.weights;
  problem.normal_form = options.solving.normal_form;
  problem.start = {base.solved.X_WH, hand::poseOfVariant(variant, base.solved.q)};
  problem.prior = base.prior;  // also beyond a row's limits: all rows are pulled alike
  problem.prior_weights = base.prior_weights;
  if (options.solving.avoids()) problem.avoidance = solids;
  solution.report = optimize::solve(problem, solveOptions(options.solving), progress);
  solution.patches = base.patches;
  return solution;
}

const session::Solution& betterOf(const session::Solution& anew,
                                  const session::Solution& kept) {
  const auto [lacking_anew, cost_anew] = session::worthOf(anew);
  const auto [lacking_kept, cost_kept] = session::worthOf(kept);
  if (lacking_anew != lacking_kept) return lacking_anew < lacking_kept ? anew : kept;
  return cost_anew < cost_kept - kSmallGain * kept.report.terms.objective ? anew : kept;
}

}  // namespace handgraft::sweep
