#include "server/handlers/solving_phase.h"

#include <exception>

#include "server/base/rejection.h"

namespace handgraft::server {

SolveEnd runInPhase(LiveSession& live,
                    v1::SessionPhase phase,
                    Preemption patience,
                    const Progress& progress,
                    const SolvingStep& step) {
  const auto enter_and_step = [&](SolveCycle::Run& run) {
    live.enter(phase);
    const Progress told(run.progress(), [&](std::string_view stage, double fraction) {
      live.advance(stage, fraction);
      run.progress().report(stage, fraction);
    });
    step(run, told);
  };
  SolveEnd end = SolveEnd::kDone;
  try {
    end = live.cycle().run(progress, patience, enter_and_step);
  } catch (const std::exception& error) {
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
  if (end == SolveEnd::kDone) {
    live.settle(v1::PHASE_READY);
  } else {
    live.tellEnd(end);
  }
  return end;
}

void requireDone(SolveEnd end, LiveSession& live) {
  switch (end) {
    case SolveEnd::kDone:
      return;
    case SolveEnd::kStopped:
      reject(v1::ERROR_CANCELLED, "session {}: {}", live.id(), live.cycle().whoStopped());
    case SolveEnd::kCutShort:
      rejectOutdated(live.id());
    case SolveEnd::kCancelled:
      throw Cancelled();
  }
}

void rejectOutdated(std::uint64_t session_id) {
  reject(v1::ERROR_CANCELLED,
         "session {}: an edit came while this was solved; a fresh solution follows it",
         session_id);
}

}  // namespace handgraft::server
