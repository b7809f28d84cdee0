#pragma once

#include <cstdint>
#include <functional>

#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Runs a step as what edits may cut short and anybody may stop (`SolveCycle::run`), in a phase
/// of the session's state, which tells how it ended: PHASE_READY, why it failed, or that it was
/// cancelled. `told` are its reports and its wish to stop. Of the strand. Errors: those of
/// `step`.
using SolvingStep = std::function<void(SolveCycle::Run& run, const Progress& told)>;
SolveEnd runInPhase(LiveSession& live,
                    v1::SessionPhase phase,
                    Preemption patience,
                    const Progress& progress,
                    const SolvingStep& step);

/// For requests, which are answered: goes on where it is done. Errors: Rejection
/// (ERROR_CANCELLED) with who stopped it, or that an edit came; Cancelled on wish.
void requireDone(SolveEnd end, LiveSession& live);

/// An edit that came while a request was solved was applied. Errors: Rejection
/// (ERROR_CANCELLED), always.
[[noreturn]] void rejectOutdated(std::uint64_t session_id);

}  // namespace handgraft::server
