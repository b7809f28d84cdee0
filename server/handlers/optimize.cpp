#include "server/handlers/optimize.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "core/session/solids.h"
#include "server/handlers/kept_sessions.h"
#include "server/handlers/motions.h"
#include "server/handlers/transfer.h"
#include "server/messages/convert.h"
#include "server/messages/solution_messages.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kSolutionPeriod(1000);  // of poses on the way
// Solves that end sooner show their answer alone: nobody sees poses of less than a frame, and
// each costs both sides a message.
constexpr std::chrono::milliseconds kQuietStart(5);
constexpr int kStartsAfterEdit = 2;  // where the hand is, and its joints under the closed form
// Before an edit cuts a solve short: most end by themselves then. Twice as long after each that
// was cut short, so that one ends some time; less so where the edits were applied
// (service.cpp).
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

std::vector<v1::StageTime> timesOf(const LiveSession& live,
                                   const UnexplainedPose& pose,
                                   double solids_ms) {
  return {stageTime("skin", live.skin_ms), stageTime("transfer", pose.transfer_ms),
          stageTime("optimize", pose.optimize_ms), stageTime("solids", solids_ms),
          stageTime("report", pose.report_ms)};
}

/// Publishes a pose as soon as it is known, and keeps it for its explanation.
void publishUnexplained(LiveSession& live,
                        const session::Solving& solving,
                        UnexplainedPose pose) {
  live.solved_revision = live.session().revision();
  pose.asked_at_stops = live.asked_at_stops;
  pose.transfer_ms = std::exchange(live.untold_transfer_ms, 0.0);
  pose.message.options(toMessage(solving));
  pose.message.chosen_minimum(static_cast<std::uint32_t>(live.session().chosenMinimum()));
  pose.message.times(timesOf(live, pose, 0.0));
  pose.message = live.publish(std::move(pose.message));
  live.unexplained = std::make_shared<UnexplainedPose>(std::move(pose));
}

/// Publishes the pose that is out once more, explained.
void publishExplained(LiveSession& live, UnexplainedPose& pose, const Progress& progress) {
  progress.checkpoint();
  const double solids_ms = awaitSolids(live.session(), progress);
  const Clock::time_point begin = Clock::now();
  v1::PoseSolution explained = pose.message;
  explain(live.session(), pose.problem, pose.report, live.fit_check, explained, progress);
  pose.report_ms += msSince(begin);
  explained.times(timesOf(live, pose, solids_ms));
  pose.message = live.publish(std::move(explained));
}

void explainLater(LiveSession& live);

/// Explains the pose that is out, and rests; later if an edit comes first, which may be
/// refused. The pose stands whatever ends its explanation, and is returned as it was published
/// last.
v1::PoseSolution explainNow(LiveSession& live, const Progress& progress) {
  const std::shared_ptr<UnexplainedPose> pose = live.unexplained;
  Progress stoppable(progress, [&](std::string_view stage, double fraction) {
    live.advance(stage, fraction);
    progress.report(stage, fraction);
  });
  LiveSession::SolveInFlight flight(live, stoppable, std::chrono::milliseconds(0));
  flight.giveWay();  // to an edit that came before
  try {
    publishExplained(live, *pose, stoppable);
  } catch (const Cancelled&) {
    if (flight.wasCutShort() && !flight.wasStopped()) {
      explainLater(live);
      return pose->message;
    }
  } catch (const std::exception& error) {
    live.unexplained = nullptr;
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
  live.unexplained = nullptr;
  live.settle(v1::PHASE_READY);
  keepState(live);
  return pose->message;
}

/// Unless the pose is outdated by then.
void explainLater(LiveSession& live) {
  const auto explainIt = [self = live.shared_from_this(),
                          pose = std::weak_ptr<UnexplainedPose>(live.unexplained)] {
    const auto mine = pose.lock();
    if (!mine || mine != self->unexplained) return;
    if (self->state().phase() == v1::PHASE_CLOSED) return;
    self->asked_at_stops = mine->asked_at_stops;
    try {
      explainNow(*self, self->solves());
    } catch (const std::exception& error) {  // nobody waits for a reply
      spdlog::info("event=explain session={} message={}", self->id(),
                   handgraft::quoted(error.what()));
    }
  };
  live.strand().postIdleFromTask(explainIt);
}

/// Solves, publishes better poses on the way, takes the answer and publishes it.
void solveAndTake(LiveSession& live,
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
  const Clock::time_point solved = Clock::now();
  UnexplainedPose pose;
  pose.optimize_ms = std::chrono::duration<double, std::milli>(solved - begin).count();
  pose.report = solution.report;
  const session::LogEntry committed = session.commit(std::move(solution));
  if (live.journal) live.journal->keep(io::entryText(committed));
  live.was_solved = true;
  live.solves_cut_short = 0;
  pose.message = solutionMessage(session, pose.report);
  pose.problem = *session.solvedProblem();
  pose.report_ms = msSince(solved);
  publishUnexplained(live, solving, std::move(pose));
}

/// Runs `step(flight, told)` in a phase, as something that edits may cut short after `least`
/// and that anybody may stop.
template <class Step>
void fly(LiveSession& live,
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
    runPhase(live, phase, v1::PHASE_READY, stoppable, [&](const Progress& told) {
      step(flight, told);
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

/// What a solve has before an edit cuts it short.
std::chrono::milliseconds leastOf(const LiveSession& live) {
  return kLeastSolve * (1 << std::min(live.solves_cut_short, kMostDoublings));
}

void solve(LiveSession& live,
           const session::Solving& solving,
           bool places_stay,
           Workshop& workshop,
           const Progress& progress) {
  fly(live, v1::PHASE_OPTIMIZING, leastOf(live), progress,
      [&](LiveSession::SolveInFlight& flight, const Progress& told) {
        try {
          solveAndTake(live, solving, places_stay, workshop, flight, told);
        } catch (const Cancelled&) {
          live.session().noteCancelledSolve();
          if (live.journal) live.journal->note(io::entryText(session::CancelledSolve()));
          throw;
        }
      });
}

/// What stands after an undo, a redo or a restore needs no search.
void publishStanding(LiveSession& live, const Progress& progress) {
  fly(live, v1::PHASE_TRANSFERRING, kUnhurried, progress,
      [&](LiveSession::SolveInFlight&, const Progress& told) {
        session::Session& session = live.session();
        bringUpToDate(live, told);
        const Clock::time_point begin = Clock::now();
        session::Solution standing = session.standing(told);
        UnexplainedPose pose;
        pose.message = solutionMessage(session, standing.problem, standing.report);
        pose.problem = std::move(standing.problem);
        pose.report = std::move(standing.report);
        pose.report_ms = msSince(begin);
        publishUnexplained(live, session.document().solving, std::move(pose));
      });
}

}  // namespace

void flyMotion(LiveSession& live,
               const Progress& progress,
               const std::function<void(const Progress& told)>& step) {
  fly(live, v1::PHASE_OPTIMIZING, leastOf(live), progress,
      [&](LiveSession::SolveInFlight&, const Progress& told) {
        step(told);
        live.solves_cut_short = 0;
      });
}

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
    publishStanding(live, progress);
  } else {
    const session::Solving solving = request.options().empty()
                                         ? live.session().document().solving
                                         : solvingFrom(request.options().front());
    solve(live, solving, false, workshop, progress);
  }
  return explainNow(live, progress);
}

void optimizeAfterEdit(LiveSession& live, Workshop& workshop, const Progress& progress) {
  const session::Session& session = live.session();
  // Beside a motion that follows edits, the grasp that stands for it is shown as it is: a
  // search would move the prior of the motion, too.
  if (!session.needsSolve() || followsEdits(live)) {
    publishStanding(live, progress);
  } else {
    session::Solving solving = session.document().solving;
    const bool follows = session.document().start_is_known;
    if (follows && solving.starts == optimize::kDefaultStarts && !solving.paper) {
      solving.starts = kStartsAfterEdit;
    }
    solve(live, solving, follows, workshop, progress);
  }
  explainLater(live);
}

}  // namespace handgraft::server
