#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/progress.h"
#include "core/session/session.h"
#include "idl/sensor_msgs.h"
#include "idl/sessions.h"
#include "server/worker_pool.h"

namespace handgraft::server {

/// Who hears of the changes of sessions. Called from workers.
class SessionAudience {
 public:
  virtual ~SessionAudience() = default;
  virtual void onState(const v1::SessionState& state) = 0;
  virtual void onSolution(const v1::PoseSolution& solution) = 0;
  virtual void onJointCommand(std::uint64_t session_id,
                              const sensor_msgs::msg::dds_::JointState_& command) = 0;
};

/// What a session is made of, by name.
struct SessionNames {
  std::string hand;
  std::string object;
  std::string contacts;
};

/// A session as the server runs it: the editable problem, its strand, and what is told of it.
///
/// Threads: `session`, and what is said to belong to the strand, from tasks of `strand` alone;
/// the rest from any thread.
class LiveSession {
 public:
  LiveSession(std::uint64_t id,
              SessionNames names,
              session::Session session,
              WorkerPool& pool,
              SessionAudience& audience);

  [[nodiscard]] std::uint64_t id() const { return id_; }

  [[nodiscard]] Strand& strand() { return strand_; }

  [[nodiscard]] v1::SessionState state() const;

  /// Sets phase, message and progress, and tells the audience. Nothing follows PHASE_CLOSED.
  void enter(v1::SessionPhase phase, const std::string& message = "", double progress = 0.0);
  /// As above within the present phase, at most ten times a second.
  void advance(std::string_view stage, double fraction);

  /// Cancels what runs or waits on the strand for the sake of an edit, and all that comes
  /// later.
  void cancelSolves() { solves_.cancel(); }

  [[nodiscard]] const Progress& solves() const { return solves_; }

  // === Of the strand

  [[nodiscard]] session::Session& session() { return session_; }

  /// Numbers, stamps and publishes a solution; the same message is returned. A final one also
  /// goes out as a joint command.
  v1::PoseSolution publish(v1::PoseSolution solution);

  bool solve_is_queued = false;
  bool was_solved = false;
  unsigned long long solved_revision = 0;
  // What the stages took, for the solution's times.
  double skin_ms = 0.0;      ///< of opening the session
  double transfer_ms = 0.0;  ///< of the last transfer that had something to do

 private:
  const std::uint64_t id_;
  session::Session session_;
  SessionAudience& audience_;
  Strand strand_;
  Progress solves_;
  std::uint64_t sequence_number_ = 0;

  mutable std::mutex mutex_;
  v1::SessionState state_;
  std::chrono::steady_clock::time_point told_{};
};

/// Nanoseconds of the system's clock.
long long nowNs();

/// Runs one step of work in a phase: tells its progress, then PHASE_READY or PHASE_OPEN
/// (`after`), or why it failed. Exceptions pass through; a cancelled step leaves the phase as
/// it was.
template <class Step>
auto runPhase(LiveSession& live,
              v1::SessionPhase phase,
              v1::SessionPhase after,
              const Progress& progress,
              const Step& step) {
  const v1::SessionPhase before = live.state().phase();
  live.enter(phase);
  const Progress told(progress, [&](std::string_view stage, double fraction) {
    live.advance(stage, fraction);
    progress.report(stage, fraction);
  });
  try {
    auto result = step(told);
    live.enter(after);
    return result;
  } catch (const Cancelled&) {
    live.enter(before, "cancelled");
    throw;
  } catch (const std::exception& error) {
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
}

}  // namespace handgraft::server
