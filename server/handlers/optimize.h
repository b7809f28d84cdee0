#pragma once

#include <optional>

#include "core/base/progress.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/solver.h"
#include "idl/sessions.h"
#include "server/handlers/handler_context.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// A final pose that is out, and what its diagnosis is made of.
struct UndiagnosedPose {
  v1::PoseSolution message;  ///< as it was published
  optimize::PoseProblem problem;
  optimize::SolveReport report;
  bool goes_on = false;  ///< from the pose before, as after an edit: no search of the whole
  // What the stages took.
  double transfer_ms = 0.0;
  double sizes_ms = 0.0;  ///< of looking, before the first search, whether the hand fits
  double optimize_ms = 0.0;
  double report_ms = 0.0;
};

/// Transfers what is not up to date and solves, the session's own way unless the request says
/// another; better poses on the way are published, at most 1000 a second, and the final one is,
/// then once more when it is diagnosed, and is returned. An edit, a stop or the client's wish
/// after the pose is out end the diagnosis alone; the pose is returned as it is, and diagnosed
/// later if that edit is refused. Nothing where an edit cut the solve short: applied, it has
/// its own solution; refused, the solve is to be begun again. Of the session's strand. Errors:
/// Rejection (ERROR_CANCELLED) if somebody stopped it; Cancelled on wish.
std::optional<v1::PoseSolution> optimizePose(LiveSession& live,
                                             const v1::OptimizeRequest& request,
                                             HandlerContext& context,
                                             const Progress& progress);

/// The pose of the session as it stands: what stands, after undo and the like; else the
/// session's way of solving, where the number of starts was left to us from where the hand is,
/// with two, and with roots and directions where they are, so that it follows a drag. Diagnosed
/// by an idle task of the strand: what other sessions have to do comes first. Errors: those of
/// solving.
SolveEnd solveAsItStands(LiveSession& live, HandlerContext& context, const Progress& progress);

/// The same as the answer to edits; where the session follows a motion, its frames then.
SolveEnd solveAfterEdit(LiveSession& live, HandlerContext& context);

/// As above for a session that was opened with a pose, so that those who watch see it; if not
/// now, after the next edit. The session's state says what went wrong.
void solveAfterOpening(LiveSession& live, HandlerContext& context);

}  // namespace handgraft::server
