#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/live_session.h"

namespace handgraft::server {

/// The problem file of what was solved last, exactly; of the problem as it stands if there were
/// edits since, or nothing was solved. Of the session's strand.
v1::ExportProblemReply exportProblem(LiveSession& live,
                                     const v1::ExportProblemRequest& request,
                                     const Progress& progress);

}  // namespace handgraft::server
