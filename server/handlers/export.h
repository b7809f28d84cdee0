#pragma once

#include <optional>

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/handlers/handler_context.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// A file of a session (core/io/README, "Grasps for other programs"). `problem` is what was
/// solved last, exactly, or the problem as it stands if there were edits since, or nothing was
/// solved; the others are the pose that answers the last edit, solved first if need be. Of the
/// session's strand. Nothing where an edit cut that solve short (handlers/optimize.h).
///
/// Errors: InvalidInput for a format that there is not, and where there is no pose yet.
std::optional<v1::ExportReply> exportSession(LiveSession& live,
                                             const v1::ExportRequest& request,
                                             HandlerContext& context,
                                             const Progress& progress);

}  // namespace handgraft::server
