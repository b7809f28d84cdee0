#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Lays what is not up to date onto the hand, and notes in `live` how long that took. Of the
/// session's strand.
void updateTransfers(LiveSession& live, const Progress& progress);

/// As above, in the phase of that name, and told to whoever asked. Of the session's strand.
v1::TransferReply transferPatches(LiveSession& live, const Progress& progress);

}  // namespace handgraft::server
