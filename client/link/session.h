#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "client/link/client.h"
#include "client/link/session_stream.h"
#include "idl/edits.h"

namespace handgraft::client {

/// The server could not solve what an edit asked for: its own words.
class SolveFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One session of a server: its edits, what can be asked about it, its streams. It stays open
/// on the server when this goes; `close` ends it.
///
/// Errors of every call: those of Client; Refused (ERROR_NOT_FOUND) of a session that has been
/// closed or has ended with its server.
/// Threads: one; the client may be used from others meanwhile.
class Session {
 public:
  /// Of a session that the server told of: openSession, describeSession or loadSession.
  Session(Client& client, const v1::SessionState& state);

  [[nodiscard]] Client& client() const { return client_; }

  [[nodiscard]] std::uint64_t id() const { return state_.session_id(); }

  /// As last heard.
  [[nodiscard]] const v1::SessionState& state() const { return state_; }

  /// Its server is gone and another one answers, which may give its id to another session.
  [[nodiscard]] bool hasEnded() const;
  /// Errors: Refused (ERROR_NOT_FOUND) if it has been closed or has ended with its server.
  void requireStanding() const;
  /// Likewise, and NoServer if its server does not answer.
  void requireOpen() const;

  // === Asking; none of these waits

  Pending<v1::EditReply> edit(const v1::EditBody& body,
                              std::uint64_t base_revision = 0,
                              const std::optional<v1::EditTime>& when = {});
  /// `options`: for this once; nothing: the session's.
  Pending<v1::PoseSolution> solve(const std::optional<v1::SolveOptions>& options = {});

  Pending<v1::SessionSettings> settings() { return client_.settings(id()); }

  Pending<v1::TransferReply> transfer() { return client_.transfer(id()); }

  Pending<std::string> save() { return client_.saveSession(id()); }

  Pending<Done> stopSolving() { return client_.stopSolving(id()); }

  Pending<Done> close() { return client_.closeSession(id()); }

  // === Following

  using OnSolution = SessionStream::OnSolution;
  using OnState = SessionStream::OnState;
  using Timeout = std::chrono::milliseconds;
  static constexpr Timeout kEndless = std::chrono::hours(1000);

  /// The last final pose that was heard; nullptr before there is one.
  [[nodiscard]] const v1::PoseSolution* solution() const {
    return solution_ ? &*solution_ : nullptr;
  }

  /// What edits changed of its motion, since the last call, in order.
  std::vector<v1::MotionFrames> takeMotion() { return stream_.takeMotion(); }

  /// The clock of its motion, where it was set since the last call.
  std::optional<v1::MotionClock> takeClock() { return stream_.takeClock(); }

  /// Takes what has come, all that is this session's.
  void take(const OnSolution& on_solution = {}, const OnState& on_state = {});

  /// Waits until there may be something to take, or so long.
  void wait(Timeout timeout) { stream_.wait(timeout); }

  /// The pose that a session joined just now has already: waits for it up to 2 s after this was
  /// made.
  const v1::PoseSolution* joinedSolution();

  /// Waits for the final pose of `revision` or a later one, diagnosed or not; `on_solution`
  /// sees those before it. nullptr if none follows: the session rests at that revision.
  /// Errors: SolveFailed; what the client's checkpoint throws (the server goes on).
  const v1::PoseSolution* awaitFinal(std::uint64_t revision,
                                     const OnSolution& on_solution = {});

  /// Waits until the last final pose, of `revision`, is diagnosed. Returns what is the last by
  /// then: it is not diagnosed if an edit came first, the diagnosis was stopped, or `longest`
  /// is over. There must be a final pose. Errors: as for `awaitFinal`, but for SolveFailed.
  const v1::PoseSolution& awaitDiagnosed(std::uint64_t revision, Timeout longest = kEndless);

  /// What was asked for counts as heard, unless the stream has brought a later one.
  const v1::PoseSolution& adopt(const v1::PoseSolution& solution);
  void adopt(const v1::SessionState& state);

 private:
  /// Since when nothing more will come for a revision, unless it is on its way.
  class Rest;
  [[nodiscard]] bool restsAt(std::uint64_t revision) const;

  Client& client_;
  SessionStream stream_;
  v1::SessionState state_;
  const std::uint64_t server_id_;
  const std::chrono::steady_clock::time_point joined_ = std::chrono::steady_clock::now();
  std::optional<v1::PoseSolution> solution_;
};

}  // namespace handgraft::client
