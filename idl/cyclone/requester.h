#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/error.h"
#include "idl/cyclone/participant.h"
#include "idl/edits.h"
#include "idl/service.h"

namespace handgraft::idl::cyclone {

/// What the server answered when it refused: its own words, and the kind.
class Refused : public std::runtime_error {
 public:
  Refused(v1::ErrorCode code, const std::string& message)
      : std::runtime_error(message), code_(code) {}

  [[nodiscard]] v1::ErrorCode code() const { return code_; }

 private:
  v1::ErrorCode code_;
};

/// No server: the message says on which domain and interface.
class NoServer : public TransportError {
 public:
  using TransportError::TransportError;
};

/// Asks the server and waits. A request is repeated with the same id every 50 ms until the
/// reply comes; the server does the work once, so nothing is lost while discovery settles.
/// Large bodies and long work are repeated more slowly.
///
/// Threads: one caller at a time; `cancel` and `status` from any thread. Receives on a thread
/// of its own, where what answers other clients is dropped.
class Requester {
 public:
  explicit Requester(const Participant& participant);
  ~Requester();

  /// True as soon as a server has been seen alive on this domain; waits at most `timeout`.
  bool waitForServer(std::chrono::milliseconds timeout = std::chrono::milliseconds(2000));
  /// As above. Errors: NoServer; Refused (ERROR_VERSION) by a server of another protocol.
  void requireServer();

  using OnProgress = std::function<void(const std::string& stage, double fraction)>;

  /// The reply's body. Errors: Refused with the server's message; NoServer if none has been
  /// seen for 2 s, or, in the middle of a long request, when it has been silent for 3 s;
  /// TransportError for a body that does not fit its IDL bounds or is larger than
  /// kLargestRequest. `on_progress` runs on the caller's thread.
  v1::ReplyBody ask(const v1::RequestBody& body, const OnProgress& on_progress = {});

  /// Publishes an edit until it is answered. Errors as for `ask`.
  v1::EditReply edit(std::uint64_t session_id,
                     std::uint64_t base_revision,
                     const v1::EditBody& body);

  /// Asks the server to stop what `ask` waits for; `ask` then throws Refused (ERROR_CANCELLED),
  /// or returns if the work was done already. Nothing happens while nobody asks. From any
  /// thread (not from a signal handler).
  void cancel();

  /// The name under which this asks and edits; states tell whose the last edit was.
  [[nodiscard]] v1::ClientId client() const;

  /// The last status of the server seen; all zero (server_id 0) before the first.
  [[nodiscard]] v1::ServerStatus status() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::idl::cyclone
