#include "server/handlers/optimize.h"

#include <chrono>
#include <utility>

#include "core/session/solids.h"
#include "server/convert.h"
#include "server/handlers/transfer.h"
#include "server/rejection.h"
#include "server/solution_messages.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kSolutionPeriod(1000);  // of poses on the way
// Solves that end sooner show their answer alone. Replaced before it was sent, a pose on the
// way leaves a gap that holds the final one up until the next heartbeat.
constexpr std::chrono::milliseconds kQuietStart(5);
constexpr int kStartsAfterEdit = 2;  // where the hand is, and its joints under the closed form

v1::StageTime stageTime(const char* stage, double duration_ms) {
  v1::StageTime time;
  time.stage(stage);
  time.duration_ms(duration_ms);
  return time;
}

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Hand and object as solids, which the report needs; how long they were waited for, ms.
double awaitSolids(const session::Session& session, const Progress& progress) {
  const Clock::time_point begin = Clock::now();
  session::makeSolids(session.hand(), session.sharedObject(), progress);
  return msSince(begin);
}

/// The final message, with what the stages took; `begin` is when the message was begun.
v1::PoseSolution published(LiveSession& live,
                           v1::PoseSolution solution,
                           const session::Solving& solving,
                           double optimize_ms,
                           double solids_ms,
                           Clock::time_point begin) {
  solution.options(toMessage(solving));
  solution.chosen_minimum(static_cast<std::uint32_t>(live.session().chosenMinimum()));
  solution.times({stageTime("skin", live.skin_ms),
                  stageTime("transfer", live.untold_transfer_ms),
                  stageTime("optimize", optimize_ms), stageTime("solids", solids_ms),
                  stageTime("report", msSince(begin))});
  live.untold_transfer_ms = 0.0;
  return live.publish(std::move(solution));
}

/// Solves, publishes better poses on the way, takes the answer and publishes it.
v1::PoseSolution solveAndTake(LiveSession& live,
                              const session::Solving& solving,
                              bool places_stay,
                              Workshop& workshop,
                              LiveSession::SolveInFlight& flight,
                              const Progress& told) {
  session::Session& session = live.session();
  bringUpToDate(live, told);
  if (!live.was_solved) {
    // Sizes that no pose can help are told before the search.
    const std::string known = foretell(session, live.fit_check);
    if (!known.empty()) live.enter(v1::PHASE_OPTIMIZING, known);
  }
  const Clock::time_point begin = Clock::now();
  const Workshop::Share share(workshop);
  session::SolveRun run;
  run.threads = share.threads();
  run.places_stay = places_stay;
  Clock::time_point last{};
  run.on_improvement = [&](const hand::HandPose& pose, const optimize::Terms& terms) {
    flight.giveWay();
    const Clock::time_point now = Clock::now();
    if (now - begin < kQuietStart || now - last < kSolutionPeriod) return;
    last = now;
    v1::PoseSolution on_the_way = solutionMessage(session, pose, terms);
    on_the_way.solver(std::string(optimize::nameOf(solving.solver)));
    live.publish(std::move(on_the_way));
  };
  session::Solution solution = session.solve(solving, run, told);
  const double spent_ms = msSince(begin);
  // Nothing is taken of a solve that is cancelled while it waits here.
  const double solids_ms = awaitSolids(session, told);
  const Clock::time_point solved = Clock::now();
  const optimize::SolveReport report = solution.report;
  session.commit(std::move(solution));
  live.was_solved = true;
  live.solved_revision = session.revision();
  v1::PoseSolution message = solutionMessage(session, report);
  explain(session, *session.solvedProblem(), report, live.fit_check, message);
  return published(live, std::move(message), solving, spent_ms, solids_ms, solved);
}

v1::PoseSolution solve(LiveSession& live,
                       const session::Solving& solving,
                       bool places_stay,
                       Workshop& workshop,
                       const Progress& progress) {
  LiveSession::SolveInFlight* in_flight = nullptr;
  Progress stoppable(progress, [&](std::string_view stage, double fraction) {
    in_flight->giveWay();
    progress.report(stage, fraction);
  });
  LiveSession::SolveInFlight flight(live, stoppable);
  in_flight = &flight;
  try {
    return runPhase(live, v1::PHASE_OPTIMIZING, v1::PHASE_READY, stoppable,
                    [&](const Progress& told) {
                      return solveAndTake(live, solving, places_stay, workshop, flight, told);
                    });
  } catch (const Cancelled&) {
    live.session().noteCancelledSolve();
    if (!flight.wasCutShort()) throw;
    reject(v1::ERROR_CANCELLED,
           "session {}: an edit came while this was solved; a fresh solution follows it",
           live.id());
  }
}

/// What stands after an undo, a redo or a restore needs no search.
v1::PoseSolution publishStanding(LiveSession& live, const Progress& progress) {
  return runPhase(
      live, v1::PHASE_TRANSFERRING, v1::PHASE_READY, progress, [&](const Progress& told) {
        session::Session& session = live.session();
        bringUpToDate(live, told);
        const session::Solution standing = session.standing(told);
        const double solids_ms = awaitSolids(session, told);
        const Clock::time_point begin = Clock::now();
        live.solved_revision = session.revision();
        v1::PoseSolution message = solutionMessage(session, standing.problem, standing.report);
        explain(session, standing.problem, standing.report, live.fit_check, message);
        return published(live, std::move(message), session.document().solving, 0.0, solids_ms,
                         begin);
      });
}

}  // namespace

v1::PoseSolution optimizePose(LiveSession& live,
                              const v1::OptimizeRequest& request,
                              Workshop& workshop,
                              const Progress& progress) {
  // A minimum that was chosen stands until somebody asks for another search.
  if (request.options().empty() && live.session().chosenMinimum() > 0 &&
      !live.session().needsSolve()) {
    return publishStanding(live, progress);
  }
  const session::Solving solving = request.options().empty()
                                       ? live.session().document().solving
                                       : solvingFrom(request.options().front());
  return solve(live, solving, false, workshop, progress);
}

v1::PoseSolution optimizeAfterEdit(LiveSession& live,
                                   Workshop& workshop,
                                   const Progress& progress) {
  const session::Session& session = live.session();
  if (!session.needsSolve()) return publishStanding(live, progress);
  session::Solving solving = session.document().solving;
  const bool follows = session.document().start_is_known;
  if (follows && solving.starts == optimize::kDefaultStarts && !solving.paper) {
    solving.starts = kStartsAfterEdit;
  }
  return solve(live, solving, follows, workshop, progress);
}

}  // namespace handgraft::server
