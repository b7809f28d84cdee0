#pragma once

#include "core/session/session.h"
#include "idl/sessions.h"

/// Sessions as they stand, to messages.
namespace handgraft::server {

/// All that a user may change; `state` is filled in by the caller.
v1::SessionSettings settingsMessage(const session::Session& session);

v1::CompareReply toMessage(const std::vector<session::Difference>& differences);

}  // namespace handgraft::server
