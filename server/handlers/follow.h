#pragma once

#include "idl/motions.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Answers a demonstrator's frame by a final pose on the session's stream, once the
/// demonstrator has touched the object. A frame that is wrong changes nothing: why is told by
/// the session's warning, until one is right. Of the session's strand; throws nothing.
void followFrame(LiveSession& live, const v1::DemonstratorFrame& frame);

}  // namespace handgraft::server
