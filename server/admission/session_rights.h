#pragma once

#include "idl/service.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// True of an operation that changes what a session is or shows, which not all who may ask for
/// it may do to every session.
bool modifiesSession(v1::Operation operation);

/// Errors: Rejection (ERROR_NOT_PERMITTED).
void requireMayDo(v1::Operation operation, const LiveSession& live, const Who& who);

}  // namespace handgraft::server
