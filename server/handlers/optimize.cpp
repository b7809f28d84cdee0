#include "server/handlers/optimize.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/session/solids.h"
#include "server/convert.h"
#include "server/handlers/transfer.h"
#include "server/solution_messages.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kSolutionPeriod(1000);  // of poses on the way
// Solves that end sooner show their answer alone: nobody sees poses of less than a frame, and
// each costs both sides a message.
constexpr std::chrono::milliseconds kQuietStart(5);
constexpr int kStartsAfterEdit = 2;  // where the hand is, and its joints under the closed form
// Before an edit cuts a solve short: most end by themselves then. Twice as long after each that
// was cut short for an edit that was refused then, so that it ends some time.
constexpr std::chrono::milliseconds kLeastSolve(8);
constexpr int kMostDoublings = 12;
constexpr std::chrono::hours kUnhurried(1);  // what needs no search is not cut short

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

/// A final pose on its way out, and what is told beside it.
struct Answer {
  v1::PoseSolution message;
  const optimize::PoseProblem& problem;
  const optimize::SolveReport& report;
  const session::Solving& solving;
  double optimize_ms = 0.0;
  Clock::time_point begin;  ///< of the message
};

/// Publishes a pose as soon as it is known, and once more when it is explained; what was
/// published last. The pose stands whatever cuts its explanation short.
v1::PoseSolution publishAndExplain(LiveSession& live,
                                   Answer answer,
                                   LiveSession::SolveInFlight& flight,
                                   const Progress& told) {
  v1::PoseSolution& message = answer.message;
  const auto timesWith = [&](double solids_ms) -> std::vector<v1::StageTime> {
    return {stageTime("skin", live.skin_ms), stageTime("transfer", live.untold_transfer_ms),
            stageTime("optimize", answer.optimize_ms), stageTime("solids", solids_ms),
            stageTime("report", msSince(answer.begin) - solids_ms)};
  };
  live.solved_revision = live.session().revision();
  message.options(toMessage(answer.solving));
  message.chosen_minimum(static_cast<std::uint32_t>(live.session().chosenMinimum()));
  message.times(timesWith(0.0));
  message = live.publish(std::move(message));
  flight.beginToExplain();
  live.owes_explanation = false;
  try {
    told.checkpoint();
    v1::PoseSolution explained = message;
    const double solids_ms = awaitSolids(live.session(), told);
    explain(live.session(), answer.problem, answer.report, live.fit_check, explained, told);
    explained.times(timesWith(solids_ms));
    message = live.publish(std::move(explained));
  } catch (const Cancelled&) {
    live.owes_explanation = flight.wasCutShort();
  }
  live.untold_transfer_ms = 0.0;
  return std::move(message);
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
  session::SolveRun run;
  Clock::time_point last{};
  run.places_stay = places_stay;
  run.on_improvement = [&](const hand::HandPose& pose, const optimize::Terms& terms) {
    flight.giveWay();
    const Clock::time_point now = Clock::now();
    if (now - begin < kQuietStart || now - last < kSolutionPeriod) return;
    last = now;
    v1::PoseSolution on_the_way = solutionMessage(session, pose, terms);
    on_the_way.solver(std::string(optimize::nameOf(solving.solver)));
    live.publish(std::move(on_the_way));
  };
  session::Solution solution = [&] {
    const Workshop::Share share(workshop);
    run.threads = share.threads();
    return session.solve(solving, run, told);
  }();
  const double spent_ms = msSince(begin);
  const Clock::time_point solved = Clock::now();
  const optimize::SolveReport report = solution.report;
  session.commit(std::move(solution));
  live.was_solved = true;
  live.solves_cut_short = 0;
  return publishAndExplain(live,
                           {solutionMessage(session, report), *session.solvedProblem(), report,
                            solving, spent_ms, solved},
                           flight, told);
}

/// Runs `step(flight, told)` in a phase, as something that edits may cut short after `least`
/// and that anybody may stop.
template <class Step>
v1::PoseSolution fly(LiveSession& live,
                     v1::SessionPhase phase,
                     std::chrono::milliseconds least,
                     const Progress& progress,
                     const Step& step) {
  LiveSession::SolveInFlight* in_flight = nullptr;
  Progress stoppable(progress, [&](std::string_view stage, double fraction) {
    in_flight->giveWay();
    progress.report(stage, fraction);
  });
  LiveSession::SolveInFlight flight(live, stoppable, least);
  in_flight = &flight;
  try {
    if (flight.wasStopped()) {  // before it began
      live.tellCancelled();
      throw Cancelled();
    }
    return runPhase(live, phase, v1::PHASE_READY, stoppable, [&](const Progress& told) {
      return step(flight, told);
    });
  } catch (const Cancelled&) {
    if (flight.wasStopped()) {
      reject(v1::ERROR_CANCELLED, "session {}: {}", live.id(), live.whoStopped());
    }
    if (!flight.wasCutShort()) throw;
    ++live.solves_cut_short;
    throw CutShort(live.id(), live.session().revision());
  }
}

v1::PoseSolution solve(LiveSession& live,
                       const session::Solving& solving,
                       bool places_stay,
                       Workshop& workshop,
                       const Progress& progress) {
  const auto least = kLeastSolve * (1 << std::min(live.solves_cut_short, kMostDoublings));
  return fly(live, v1::PHASE_OPTIMIZING, least, progress,
             [&](LiveSession::SolveInFlight& flight, const Progress& told) {
               try {
                 return solveAndTake(live, solving, places_stay, workshop, flight, told);
               } catch (const Cancelled&) {
                 live.session().noteCancelledSolve();
                 throw;
               }
             });
}

/// What stands after an undo, a redo or a restore needs no search.
v1::PoseSolution publishStanding(LiveSession& live, const Progress& progress) {
  return fly(live, v1::PHASE_TRANSFERRING, kUnhurried, progress,
             [&](LiveSession::SolveInFlight& flight, const Progress& told) {
               session::Session& session = live.session();
               bringUpToDate(live, told);
               const Clock::time_point begin = Clock::now();
               const session::Solution standing = session.standing(told);
               return publishAndExplain(
                   live,
                   {solutionMessage(session, standing.problem, standing.report),
                    standing.problem, standing.report, session.document().solving, 0.0, begin},
                   flight, told);
             });
}

}  // namespace

CutShort::CutShort(std::uint64_t session_id, std::uint64_t solved_revision)
    : Rejection(v1::ERROR_CANCELLED,
                fmt::format("session {}: an edit came while this was solved; a fresh solution "
                            "follows it",
                            session_id)),
      revision_(solved_revision) {}

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
