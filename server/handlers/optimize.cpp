#include "server/handlers/optimize.h"

#include <chrono>
#include <utility>

#include "server/convert.h"
#include "server/handlers/transfer.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kSolutionPeriod(1'000'000 / 60);  // of poses on the way
constexpr int kStartsAfterEdit = 2;  // where the hand is, and its joints under the closed form

v1::StageTime stageTime(const char* stage, double duration_ms) {
  v1::StageTime time;
  time.stage(stage);
  time.duration_ms(duration_ms);
  return time;
}

v1::PoseSolution solve(LiveSession& live,
                       const session::Solving& solving,
                       Workshop& workshop,
                       const Progress& progress) {
  return runPhase(
      live, v1::PHASE_OPTIMIZING, v1::PHASE_READY, progress, [&](const Progress& told) {
        session::Session& session = live.session();
        bringUpToDate(live, told);
        const Clock::time_point begin = Clock::now();

        const Workshop::Share share(workshop);
        optimize::SolveOptions options = solveOptions(solving);
        options.threads = share.threads();
        Clock::time_point published{};
        options.on_improvement = [&](const hand::HandPose& pose, const optimize::Terms& terms) {
          const Clock::time_point now = Clock::now();
          if (now - published < kSolutionPeriod) return;
          published = now;
          v1::PoseSolution on_the_way = solutionMessage(session, pose, terms);
          on_the_way.solver(std::string(optimize::nameOf(options.solver)));
          live.publish(std::move(on_the_way));
        };
        const optimize::SolveReport report = session.optimize(options, told);
        const std::chrono::duration<double, std::milli> spent = Clock::now() - begin;

        live.was_solved = true;
        live.solved_revision = session.revision();
        v1::PoseSolution solution = solutionMessage(session, report);
        solution.times({stageTime("skin", live.skin_ms),
                        stageTime("transfer", live.transfer_ms),
                        stageTime("optimize", spent.count())});
        return live.publish(std::move(solution));
      });
}

}  // namespace

v1::PoseSolution optimizePose(LiveSession& live,
                              const v1::OptimizeRequest& request,
                              Workshop& workshop,
                              const Progress& progress) {
  return solve(
      live,
      request.options().empty() ? session::Solving() : solvingFrom(request.options().front()),
      workshop, progress);
}

v1::PoseSolution optimizeAfterEdit(LiveSession& live,
                                   Workshop& workshop,
                                   const Progress& progress) {
  session::Solving solving;
  if (live.was_solved) solving.starts = kStartsAfterEdit;
  return solve(live, solving, workshop, progress);
}

}  // namespace handgraft::server
