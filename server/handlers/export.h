#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/live_session.h"

namespace handgraft::server {

/// A file of a session. `problem` is what was solved last, exactly, or the problem as it stands
/// if there were edits since, or nothing was solved. Of the session's strand.
///
/// Errors: InvalidInput for a format that there is not.
v1::ExportReply exportSession(LiveSession& live,
                              const v1::ExportRequest& request,
                              const Progress& progress);

}  // namespace handgraft::server
