#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// All that a user may change of a session, as it stands. Of the session's strand.
v1::SessionSettings sessionSettings(LiveSession& live);

/// Where the links of the session's hand would be. Of the session's strand. Errors:
/// InvalidInput for another count of joints.
v1::LinkPosesReply linkPoses(LiveSession& live, const v1::LinkPosesRequest& request);

/// Where two snapshots, or one and the present, differ. Of the session's strand.
/// Errors: InvalidInput for a name that is not there.
v1::CompareReply compareSnapshots(LiveSession& live,
                                  const v1::CompareRequest& request,
                                  const Progress& progress);

}  // namespace handgraft::server
