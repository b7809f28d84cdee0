#include "server/handlers/optimize.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "core/placement/solids.h"
#include "server/handlers/kept_sessions.h"
#include "server/handlers/motions.h"
#include "server/handlers/solving_phase.h"
#include "server/handlers/transfer.h"
#include "server/log/log.h"
#include "server/messages/convert.h"
#include "server/messages/solution_messages.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds kSolutionPeriod(1000);  // of poses on the way
// Solves that end sooner show their answer alone: nobody sees poses of less than a frame, and
// each costs both sides a message.
constexpr std::chrono::milliseconds kQuietStart(5);

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
  placement::makeSolids(session.hand(), session.sharedObject(), progress);
  return msSince(begin);
}

std::vector<v1::StageTime> timesOf(const LiveSession& live,
                                   const UndiagnosedPose& pose,
                                   double solids_ms) {
  return {stageTime("skin", live.took.skin_ms), stageTime("transfer", pose.transfer_ms),
          stageTime("sizes", pose.sizes_ms),    stageTime("optimize", pose.optimize_ms),
          stageTime("solids", solids_ms),       stageTime("report", pose.report_ms)};
}

/// Publishes a pose as soon as it is known, and keeps it for its diagnosis.
void publishUndiagnosed(LiveSession& live,
                        const session::SolverSettings& solving,
                        UndiagnosedPose pose) {
  pose.transfer_ms = std::exchange(live.took.untold_transfer_ms, 0.0);
  pose.message.options(toMessage(solving));
  pose.message.chosen_minimum(static_cast<std::uint32_t>(live.session().chosenMinimum()));
  pose.message.times(timesOf(live, pose, 0.0));
  pose.message = live.publish(std::move(pose.message));
  live.cycle().poseOut(live.session().revision(),
                       std::make_shared<UndiagnosedPose>(std::move(pose)));
}

/// A patch that nobody reached by going on may well be reachable: a search of the whole took
/// the built-in claw from 2 of 3 patches to 3, and a hand of four fingers from 1 of 4 to 4.
bool mayMissTooMuch(const UndiagnosedPose& pose, const v1::PoseSolution& diagnosed) {
  return pose.goes_on && std::any_of(diagnosed.patches().begin(), diagnosed.patches().end(),
                                     [](const v1::PatchFit& fit) {
                                       const v1::Verdict verdict = fit.diagnosis().verdict();
                                       return verdict != v1::VERDICT_NONE &&
                                              verdict != v1::VERDICT_REACHED;
                                     });
}

/// Publishes the pose that is out once more, diagnosed.
void publishDiagnosed(LiveSession& live, UndiagnosedPose& pose, const Progress& progress) {
  progress.checkpoint();
  const double solids_ms = awaitSolids(live.session(), progress);
  const Clock::time_point begin = Clock::now();
  v1::PoseSolution diagnosed = pose.message;
  diagnose(live.session(), pose.problem, pose.report, live.fit_check, diagnosed, progress);
  if (mayMissTooMuch(pose, diagnosed)) {
    diagnosed.verdict(diagnosed.verdict() +
                      "; this goes on from the pose before the edit: 'solve' searches anew");
  }
  pose.report_ms += msSince(begin);
  diagnosed.times(timesOf(live, pose, solids_ms));
  pose.message = live.publish(std::move(diagnosed));
}

void diagnoseLater(LiveSession& live);

/// Diagnoses the pose that is out, and rests; later if an edit comes first, which may be
/// refused. The pose stands whatever ends its diagnosis, and is returned as it was published
/// last.
v1::PoseSolution diagnoseNow(LiveSession& live, const Progress& progress) {
  SolveCycle& cycle = live.cycle();
  const std::shared_ptr<UndiagnosedPose> pose = cycle.undiagnosed();
  const Progress told(progress, [&](std::string_view stage, double fraction) {
    live.advance(stage, fraction);
    progress.report(stage, fraction);
  });
  SolveEnd end = SolveEnd::kDone;
  try {
    end = cycle.run(told, Preemption::kNone, [&](SolveCycle::Run& run) {
      publishDiagnosed(live, *pose, run.progress());
    });
  } catch (const std::exception& error) {
    cycle.forgetUndiagnosed();
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
  if (end == SolveEnd::kCutShort) {
    diagnoseLater(live);
    return pose->message;
  }
  cycle.forgetUndiagnosed();
  live.settle(v1::PHASE_READY);
  keepState(live);
  return pose->message;
}

/// Unless the pose is outdated by then.
void diagnoseLater(LiveSession& live) {
  const auto diagnose_it = [self = live.shared_from_this(),
                            pose = std::weak_ptr<UndiagnosedPose>(live.cycle().undiagnosed())] {
    const auto mine = pose.lock();
    if (!mine || mine != self->cycle().undiagnosed() || self->isClosed()) return;
    try {
      diagnoseNow(*self, self->solves());
    } catch (const std::exception& error) {  // nobody waits for a reply
      log::info("event=diagnose session={} message={}", self->id(),
                handgraft::quoted(error.what()));
    }
  };
  live.strand().postIdleFromTask(diagnose_it);
}

/// Solves, publishes better poses on the way, takes the answer and publishes it.
void solveAndTake(LiveSession& live,
                  const session::SolverSettings& solving,
                  bool places_stay,
                  HandlerContext& context,
                  SolveCycle::Run& solve,
                  const Progress& told) {
  session::Session& session = live.session();
  updateTransfers(live, told);
  const Clock::time_point transferred = Clock::now();
  if (!live.cycle().wasSolved()) {
    // Sizes that no pose can help are told before the search.
    const std::string known = checkSizesAhead(session, live.fit_check);
    if (!known.empty()) live.enter(v1::PHASE_OPTIMIZING, known);
  }
  const Clock::time_point begin = Clock::now();
  session::SolveRun run;
  Clock::time_point last{};
  run.places_stay = places_stay;
  run.on_improvement = [&](const hand::HandPose& pose, const optimize::Terms& terms) {
    solve.cancelForEdits();
    const Clock::time_point now = Clock::now();
    if (now - begin < kQuietStart || now - last < kSolutionPeriod) return;
    last = now;
    v1::PoseSolution on_the_way = solutionMessage(session, pose, terms);
    on_the_way.solver(std::string(optimize::nameOf(solving.solver)));
    live.publish(std::move(on_the_way));
  };
  session::Solution solution = [&] {
    const HandlerContext::Share share(context);
    run.threads = share.threads();
    return session.solve(solving, run, told);
  }();
  const Clock::time_point solved = Clock::now();
  UndiagnosedPose pose;
  pose.sizes_ms = std::chrono::duration<double, std::milli>(begin - transferred).count();
  pose.optimize_ms = std::chrono::duration<double, std::milli>(solved - begin).count();
  pose.report = solution.report;
  const session::LogEntry committed = session.commit(std::move(solution));
  if (live.journal) live.journal->keep(io::entryText(committed));
  pose.message = solutionMessage(session, pose.report);
  pose.problem = *session.solvedProblem();
  pose.goes_on = places_stay;
  pose.report_ms = msSince(solved);
  publishUndiagnosed(live, solving, std::move(pose));
}

SolveEnd solve(LiveSession& live,
               const session::SolverSettings& solving,
               bool places_stay,
               HandlerContext& context,
               const Progress& progress) {
  bool has_begun = false;
  const SolveEnd end =
      runInPhase(live, v1::PHASE_OPTIMIZING, Preemption::kAnswer, progress,
                 [&](SolveCycle::Run& run, const Progress& told) {
                   has_begun = true;
                   solveAndTake(live, solving, places_stay, context, run, told);
                 });
  if (end == SolveEnd::kDone || !has_begun) return end;
  live.session().noteCancelledSolve();
  if (live.journal) live.journal->note(io::entryText(session::CancelledSolve()));
  return end;
}

/// What stands after an undo, a redo or a restore needs no search.
SolveEnd publishCurrentSolution(LiveSession& live, const Progress& progress) {
  return runInPhase(live, v1::PHASE_TRANSFERRING, Preemption::kUnhurried, progress,
                    [&](SolveCycle::Run&, const Progress& told) {
                      session::Session& session = live.session();
                      updateTransfers(live, told);
                      const Clock::time_point begin = Clock::now();
                      session::Solution standing = session.standing(told);
                      UndiagnosedPose pose;
                      pose.message =
                          solutionMessage(session, standing.problem, standing.report);
                      pose.problem = std::move(standing.problem);
                      pose.report = std::move(standing.report);
                      pose.report_ms = msSince(begin);
                      publishUndiagnosed(live, session.document().solving, std::move(pose));
                    });
}

}  // namespace

std::optional<v1::PoseSolution> optimizePose(LiveSession& live,
                                             const v1::OptimizeRequest& request,
                                             HandlerContext& context,
                                             const Progress& progress) {
  live.recallFrom(0);
  // A minimum that was chosen stands until somebody asks for another search.
  const bool stands = request.options().empty() && live.session().chosenMinimum() > 0 &&
                      !live.session().needsSolve();
  const auto solve_as_asked = [&] {
    const session::SolverSettings solving = request.options().empty()
                                                ? live.session().document().solving
                                                : solverSettingsFrom(request.options().front());
    return solve(live, solving, false, context, progress);
  };
  const SolveEnd end = stands ? publishCurrentSolution(live, progress) : solve_as_asked();
  if (end == SolveEnd::kCutShort) return std::nullopt;
  requireDone(end, live);
  return diagnoseNow(live, progress);
}

SolveEnd solveAsItStands(LiveSession& live, HandlerContext& context, const Progress& progress) {
  const session::Session& session = live.session();
  // What answers an edit of a motion that follows edits are its frames. The grasp that stands
  // for it is no answer, and must not be: a bridge would go there, out of the motion.
  if (followsEdits(live)) return SolveEnd::kDone;
  const auto solve_from_there = [&] {
    const session::SolverSettings& solving = session.document().solving;
    const bool follows = session.document().start_is_known;
    return solve(live, follows ? session::afterEdit(solving) : solving, follows, context,
                 progress);
  };
  const SolveEnd end =
      session.needsSolve() ? solve_from_there() : publishCurrentSolution(live, progress);
  if (end == SolveEnd::kDone) diagnoseLater(live);
  return end;
}

SolveEnd solveAfterEdit(LiveSession& live, HandlerContext& context) {
  const SolveEnd end = solveAsItStands(live, context, live.solves());
  if (end != SolveEnd::kDone || !followsEdits(live)) return end;
  return solveMotionAfterEdit(live, context, live.solves());
}

void solveAfterOpening(LiveSession& live, HandlerContext& context) {
  live.cycle().workFor(live.cycle().asked());
  try {
    static_cast<void>(solveAfterEdit(live, context));
  } catch (const std::exception& error) {  // the session's state says so
    log::debug("event=resume session={} message={}", live.id(),
               handgraft::quoted(error.what()));
  }
}

}  // namespace handgraft::server
