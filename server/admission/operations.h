#pragma once

#include <cstdint>
#include <optional>

#include "core/base/progress.h"
#include "idl/service.h"
#include "server/handlers/handler_context.h"
#include "server/sessions/live_session.h"
#include "server/store/state_store.h"
#include "server/transport/bus.h"

/// What the server does for each operation of the contract, and where. A new one is a line of
/// the table in operations.cpp, one of the contract's (idl/operations.cpp), and a handler.
namespace handgraft::server {

/// Where an operation runs (README, "The way of a request").
enum class Lane { kAtOnce, kQuick, kPool, kSession };

/// Errors: InvalidInput for an operation that does not exist.
Lane laneOf(v1::Operation operation);

/// A request as handlers get it. Uploads are the sender's.
struct Call {
  const v1::Request& request;
  const Sender& sender;
  HandlerContext& context;
  const Progress& progress;
  LiveSession* session = nullptr;  ///< of operations of `Lane::kSession`

  [[nodiscard]] const v1::RequestBody& body() const { return request.body(); }

  [[nodiscard]] LiveSession& live() const { return *session; }

  /// The request, as the store tells it from others, and who asked.
  [[nodiscard]] RequestKey requestKey() const;

  [[nodiscard]] Who who() const;
};

/// Does an operation; one of a session on its strand. Nothing where an edit cut short what it
/// had solved: it is to be done again if that edit is refused. Errors: Rejection
/// (ERROR_NOT_FOUND) once the session is closed; those of its handler.
std::optional<v1::ReplyBody> perform(const Call& call);

/// A request or an edit, as the store tells it from others.
RequestKey requestKeyOf(const Sender& sender, const v1::ClientId& client, std::uint64_t number);

/// What a request that leaves something behind was answered by a server before this one;
/// nothing if none did it. Errors: Rejection (ERROR_NOT_FOUND) for a session closed since.
std::optional<v1::ReplyBody> replyBefore(const Call& call);

/// The reply of an operation that has nothing to say.
v1::ReplyBody nothingSaid(v1::Operation operation);

}  // namespace handgraft::server
