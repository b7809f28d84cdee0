#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Opens a session on models of the store. The first session on a hand makes its skin.
v1::SessionState openSession(const v1::OpenSessionRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress);

/// Takes a session into the store and tells of it; `operation` made it, as asked for `by`
/// somebody. Errors: Rejection (ERROR_OVERLOADED) when too many are open; as keepSession.
std::shared_ptr<LiveSession> enterSession(session::Session session,
                                          double skin_ms,
                                          HandlerContext& context,
                                          const RequestKey& by,
                                          const std::string& operation,
                                          const Progress& progress,
                                          std::optional<LiveMotion> motion = {});

v1::SessionState describeSession(const v1::SessionKey& key, const HandlerContext& context);

v1::SessionList listSessions(const HandlerContext& context);

/// Of the session's strand: what was asked before is done. It is gone from the disk, too. `why`
/// is the last state's message. Errors: StorageError, and it stays open.
void closeSession(LiveSession& live,
                  HandlerContext& context,
                  const RequestKey& by,
                  const std::string& why = "");

}  // namespace handgraft::server
