#pragma once

#include "core/base/progress.h"
#include "core/optimize/solver.h"
#include "idl/sessions.h"
#include "server/workshop.h"

namespace handgraft::server {

/// Transfers what is not up to date and solves, the session's own way unless the request says
/// another; better poses on the way are published, at most 1000 a second, and the final one is,
/// and is returned. Of the session's strand.
/// Errors: Rejection (ERROR_CANCELLED) if an edit came meanwhile; its own solution follows.
v1::PoseSolution optimizePose(LiveSession& live,
                              const v1::OptimizeRequest& request,
                              Workshop& workshop,
                              const Progress& progress);

/// The solution that answers edits: what stands, after undo and the like; else the session's
/// way of solving, where the number of starts was left to us from where the hand is, with two,
/// and with roots and directions where they are, so that it follows a drag.
v1::PoseSolution optimizeAfterEdit(LiveSession& live,
                                   Workshop& workshop,
                                   const Progress& progress);

}  // namespace handgraft::server
