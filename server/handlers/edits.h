#pragma once

#include "idl/edits.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Applies an edit whole or not at all; revision and message of the reply. Of the session's
/// strand.
///
/// Errors: InvalidInput; Rejection (ERROR_CONFLICT) if the session has moved on since the
/// edit's base revision, naming what happened since; (ERROR_NOT_FOUND) for a model to swap to.
v1::EditReply applyEdit(LiveSession& live, const v1::Edit& edit);

}  // namespace handgraft::server
