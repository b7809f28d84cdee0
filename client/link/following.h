#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>

#include "client/link/session_stream.h"

namespace handgraft::client {

/// Whom a session's stream is told to. On a thread of the stream's own; none of them throws.
struct Listener {
  SessionStream::OnSolution on_solution = {};
  SessionStream::OnState on_state = {};
  /// Frames of its motion were solved anew.
  std::function<void(const v1::MotionFrames&)> on_frames = {};
  /// The clock that watchers of its motion share was set.
  std::function<void(const v1::MotionClock&)> on_clock = {};
  /// Nothing more will come: the session was closed (nullptr), or its server is gone
  /// (NoServer).
  std::function<void(std::exception_ptr)> on_end = {};
};

/// Tells what a session publishes as it comes, until this goes or the session ends.
class Following {
 public:
  Following(Client& client, std::uint64_t session_id, Listener listener);
  /// Returns when no callback runs any more: not to be called from one.
  ~Following();
  Following(const Following&) = delete;
  Following& operator=(const Following&) = delete;

 private:
  void run();

  Client& client_;
  const Listener listener_;
  SessionStream stream_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace handgraft::client
