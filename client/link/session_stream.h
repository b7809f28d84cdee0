#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "client/link/client.h"
#include "idl/motions.h"
#include "idl/service.h"

namespace handgraft::client {

/// What one session publishes, for who takes it when there is time. A late reader is brought
/// the session's last state and pose. Follows the client when that joins the network anew.
///
/// Threads: one.
class SessionStream {
 public:
  using OnSolution = std::function<void(const v1::PoseSolution&)>;
  using OnState = std::function<void(const v1::SessionState&)>;

  SessionStream(Client& client, std::uint64_t session_id);
  ~SessionStream();
  SessionStream(const SessionStream&) = delete;
  SessionStream& operator=(const SessionStream&) = delete;

  /// Hands over all that has come: solutions first, so that none comes after the state that
  /// says the session is closed. Both may throw; the rest comes with the next call then.
  void take(const OnSolution& on_solution, const OnState& on_state);

  /// Samples of the frames of its motion that have come since the last call; at most as many as
  /// the topic keeps.
  std::vector<v1::MotionFrames> takeMotion();

  /// The clock that watchers of its motion share, as it stood last; nothing before it was set.
  std::optional<v1::MotionClock> takeClock();

  /// Waits until there may be something to take, or so long.
  void wait(std::chrono::milliseconds timeout);

 private:
  struct Readers;
  Readers& readers();

  Client& client_;
  const std::uint64_t session_id_;
  std::unique_ptr<Readers> readers_;
};

}  // namespace handgraft::client
