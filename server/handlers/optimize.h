#pragma once

#include "core/base/progress.h"
#include "core/optimize/solver.h"
#include "idl/sessions.h"
#include "server/workshop.h"

namespace handgraft::server {

/// Transfers what is not up to date and solves; better poses on the way are published, and the
/// final one is, and is returned. Of the session's strand.
v1::PoseSolution optimizePose(LiveSession& live,
                              const v1::OptimizeRequest& request,
                              Workshop& workshop,
                              const Progress& progress);

/// The solve that answers edits: from where the hand is, with few starts, so that it follows a
/// drag.
v1::PoseSolution optimizeAfterEdit(LiveSession& live,
                                   Workshop& workshop,
                                   const Progress& progress);

}  // namespace handgraft::server
