#pragma once

#include "core/base/progress.h"
#include "idl/studies.h"
#include "server/admission/workshop.h"

namespace handgraft::server {

/// Solves every grasp, or motion, with every combination of values (core/sweep/sweep.h). No
/// session is opened. The hand's skin is made if need be.
///
/// Errors: InvalidInput as sweep::sweep, and for contacts of another mesh than the object's;
/// Rejection for unknown models; Cancelled.
v1::SweepReply sweepHand(const v1::SweepRequest& request,
                         Workshop& workshop,
                         const Progress& progress);

}  // namespace handgraft::server
