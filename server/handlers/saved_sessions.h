#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/handlers/handler_context.h"

/// Sessions as text, `handgraft-session/1` (core/io/README).
namespace handgraft::server {

/// State, history, snapshots and log, and the models that are not built-in. Of the session's
/// strand.
v1::SaveSessionReply saveSession(LiveSession& live, const HandlerContext& context);

/// Opens a saved session under a new number, on the store's models of the same names; those
/// that it lacks are taken from the file.
/// Errors: InvalidInput naming the field, the model that is another one, or what does not fit;
/// Rejection (ERROR_NOT_FOUND) for a model that there is not; as for openSession.
v1::SessionState loadSession(const v1::LoadSessionRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress);

/// Plays a saved session's log from its first state, beside all open sessions; where it ends,
/// and whether that is where the file says. Errors: as above.
v1::ReplayReply replaySession(const v1::ReplayRequest& request,
                              HandlerContext& context,
                              const Progress& progress);

}  // namespace handgraft::server
