#pragma once

#include "idl/edits.h"
#include "server/live_session.h"

namespace handgraft::server {

/// Applies an edit whole or not at all; the revision afterwards. Of the session's strand.
/// Errors: InvalidInput; Rejection (ERROR_CONFLICT) if the session has moved on since the
/// edit's base revision.
std::uint64_t applyEdit(LiveSession& live, const v1::Edit& edit);

}  // namespace handgraft::server
