#pragma once

#include <cstdint>
#include <optional>

#include "core/base/progress.h"
#include "idl/service.h"
#include "server/admission/workshop.h"
#include "server/sessions/live_session.h"
#include "server/store/state_store.h"
#include "server/transport/bus.h"

/// What each operation of the contract does, and where. A new one is a line in each function of
/// operations.cpp and a handler.
namespace handgraft::server {

/// Where an operation runs (README, "The way of a request").
enum class Lane { kAtOnce, kQuick, kPool, kSession };

/// Errors: InvalidInput for an operation that does not exist.
Lane laneOf(v1::Operation operation);

/// The session that the body of an operation of `Lane::kSession` names.
std::uint64_t sessionOf(const v1::RequestBody& body);

/// Does an operation of the quick thread or of the pool. Uploads are the sender's. Errors:
/// those of its handler.
v1::ReplyBody perform(const v1::Request& request,
                      const Sender& sender,
                      Workshop& workshop,
                      const Progress& progress);

/// Does an operation of a session; of its strand. Errors: Rejection (ERROR_NOT_FOUND) once it
/// is closed; those of its handler.
v1::ReplyBody perform(const v1::Request& request,
                      const Sender& sender,
                      LiveSession& live,
                      Workshop& workshop,
                      const Progress& progress);

/// A request or an edit, as the store tells it from others.
Mark markOf(const Sender& sender, const v1::ClientId& client, std::uint64_t number);

/// What a request that leaves something behind was answered by a server before this one;
/// nothing if none did it. Errors: Rejection (ERROR_NOT_FOUND) for a session closed since.
std::optional<v1::ReplyBody> replyBefore(const v1::Request& request,
                                         const Sender& sender,
                                         const Workshop& workshop);

/// The reply of an operation that has nothing to say.
v1::ReplyBody nothingSaid(v1::Operation operation);

}  // namespace handgraft::server
