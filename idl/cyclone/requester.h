#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

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

/// Sends requests and edits, any number at once. Each is repeated with the same id every 50 ms
/// until its reply comes; the server does the work once, so nothing is lost while discovery
/// settles. Large bodies and long work are repeated more slowly.
///
/// The server that was heard first is the one to ask until it says goodbye or has been silent
/// for 3 s, whoever else says that he is one. What names a session or an upload is for that
/// server alone, so that a repeat never falls into the hands of the next one.
///
/// Every call ends in exactly one outcome: the reply, or an error. Refused with the server's
/// message, or, by ourselves, ERROR_OTHER_SERVER when the server that was meant is gone and
/// another one answers; NoServer if none has been seen for 2 s, or, in the middle of a long
/// request, when it has been silent for 3 s, or when this requester goes; TransportError for a
/// body that does not fit its IDL bounds or is larger than kLargestRequest. An edit goes on
/// through 30 s of silence, as it may have been applied: Refused (ERROR_OUTCOME_UNKNOWN) then.
///
/// Threads: all methods from any thread. Receives on a thread of its own, where what answers
/// other clients is dropped and where outcomes and progress are told: callbacks return soon,
/// may begin and cancel calls, and must neither wait for one, destroy the requester nor throw.
class Requester {
 public:
  template <class Reply>
  using Outcome = std::variant<Reply, std::exception_ptr>;
  using OnReply = std::function<void(Outcome<v1::ReplyBody>)>;
  using OnEditReply = std::function<void(Outcome<v1::EditReply>)>;
  using OnProgress = std::function<void(const std::string& stage, double fraction)>;

  /// A request under way; numbers are never used twice.
  using CallId = std::uint64_t;

  explicit Requester(const Participant& participant);
  /// Ends what is under way: its outcome is NoServer.
  ~Requester();

  // === The server

  /// True as soon as a server has been seen alive on this domain; waits at most `timeout`.
  bool waitForServer(std::chrono::milliseconds timeout = std::chrono::milliseconds(2000));
  /// As above. Errors: NoServer; Refused (ERROR_VERSION) by a server of another protocol.
  void requireServer();

  /// The last status of the server seen; all zero (server_id 0) before the first.
  [[nodiscard]] v1::ServerStatus status() const;

  /// The name under which this asks and edits; states tell whose the last edit was.
  [[nodiscard]] v1::ClientId client() const;

  // === Several at once

  /// Sends at once, unless so many earlier requests are unanswered that the server might forget
  /// which of them it has seen: then as soon as it may.
  CallId begin(const v1::RequestBody& body, OnReply on_reply, OnProgress on_progress = {});

  /// Publishes an edit. `on_progress` is told once when the server has fallen silent, so that
  /// it is not known for now whether the edit was applied. `when`: of a motion; nothing: all.
  void beginEdit(std::uint64_t session_id,
                 std::uint64_t base_revision,
                 const v1::EditBody& body,
                 OnEditReply on_reply,
                 OnProgress on_progress = {},
                 const std::optional<v1::EditTime>& when = {});

  /// Asks the server to stop a request; its outcome then is Refused (ERROR_CANCELLED), or the
  /// reply if the work was done already. Nothing happens to one that is answered. (Not from a
  /// signal handler.)
  void cancel(CallId id);
  /// All requests under way.
  void cancel();

  // === One at a time

  /// Waits for the reply's body. `on_progress` runs on the caller's thread.
  v1::ReplyBody ask(const v1::RequestBody& body, const OnProgress& on_progress = {});

  v1::EditReply edit(std::uint64_t session_id,
                     std::uint64_t base_revision,
                     const v1::EditBody& body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::idl::cyclone
