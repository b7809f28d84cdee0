#pragma once

#include <string>

#include "core/optimize/solve_report.h"
#include "core/session/fit_check.h"
#include "core/session/session.h"
#include "idl/sessions.h"

/// What a solution says of itself on the wire.
namespace handgraft::server {

/// Adds what a final pose says of itself: verdicts, what limits would bring, sizes that do not
/// fit. `check` is the session's. Cost: as session::verdictsOf, about 0.3 ms.
void explain(const session::Session& session,
             const optimize::PoseProblem& problem,
             const optimize::SolveReport& report,
             session::FitCheck& check,
             v1::PoseSolution& message);

/// What is known of sizes before a search: the line for people, empty if all may fit.
/// Transfer first. Cost: as session::FitCheck.
std::string foretell(const session::Session& session, session::FitCheck& check);

}  // namespace handgraft::server
