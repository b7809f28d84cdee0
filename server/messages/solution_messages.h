#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/optimize/solve_report.h"
#include "core/session/session.h"
#include "core/verdict/fit_check.h"
#include "idl/sessions.h"

/// What a solution says of itself on the wire.
namespace handgraft::server {

/// Adds what a final pose says of itself: verdicts, what limits would bring, sizes that do not
/// fit, how deep the hand lies in the object and in itself. `check` is the session's.
/// Errors: Cancelled on wish; the message is then to be dropped.
/// Cost: as verdict::verdictsOf, and a millisecond; some 0.3 s where hand or object have no
/// solid yet.
void diagnose(const session::Session& session,
              const optimize::PoseProblem& problem,
              const optimize::SolveReport& report,
              verdict::FitCheck& check,
              v1::PoseSolution& message,
              const Progress& progress);

/// What is known of sizes before a search: the line for people, empty if all may fit.
/// Transfer first. Cost: as verdict::FitCheck.
std::string checkSizesAhead(const session::Session& session, verdict::FitCheck& check);

}  // namespace handgraft::server
