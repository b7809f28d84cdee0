#pragma once

#include "idl/sessions.h"
#include "server/base/session_access.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Says whom a session lets edit, and tells all who watch it. It is on disk when this returns.
/// Of its strand. Errors: those of `shared` (base/session_access.h); StorageError, and
/// nothing changed.
v1::SessionState shareSession(LiveSession& live,
                              const v1::ShareRequest& request,
                              const Who& who);

}  // namespace handgraft::server
