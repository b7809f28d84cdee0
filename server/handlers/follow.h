#pragma once

#include "idl/motions.h"
#include "server/sessions/live_session.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Answers a demonstrator's frame by a final pose on the session's stream, once the
/// demonstrator has touched the object. A frame that is wrong changes nothing: why is told by
/// the session's warning, until one is right. `models` has the hand whose joints tell a frame;
/// with the first one it is made ready, which takes seconds where its skin is not known yet.
/// Of the session's strand; throws nothing.
void followFrame(LiveSession& live,
                 const ModelStore& models,
                 const v1::DemonstratorFrame& frame);

}  // namespace handgraft::server
