#pragma once

#include "idl/motions.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Sets the clock that all watchers of the session's motion share, and publishes it.
/// Errors: InvalidInput if the session holds no motion, or a value is out of range.
v1::MotionClock setClock(LiveSession& live,
                         const v1::ClockRequest& request,
                         const v1::ClientId& client);

}  // namespace handgraft::server
