#pragma once

#include "core/base/progress.h"
#include "idl/studies.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Solves every grasp, or motion, with every combination of values (core/sweep/sweep.h). No
/// session is opened. The hand's skin is made if need be.
///
/// Errors: InvalidInput as sweep::sweep, and for contacts of another mesh than the object's;
/// Rejection for unknown models; Cancelled.
v1::SweepReply sweepHand(const v1::SweepRequest& request,
                         HandlerContext& context,
                         const Progress& progress);

}  // namespace handgraft::server
