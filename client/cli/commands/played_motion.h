#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/link/client.h"
#include "client/link/motion_player.h"
#include "idl/sessions.h"

namespace handgraft::client {

/// A session's motion as it is played: what is edited meanwhile is taken up.
///
/// A thread of its own looks for edits four times a second, since samples must not wait.
class PlayedMotion {
 public:
  using Time = PlayClock::Time;

  /// Errors: as of framesOf.
  PlayedMotion(Client& server, v1::SessionState session);
  ~PlayedMotion();
  PlayedMotion(const PlayedMotion&) = delete;
  PlayedMotion& operator=(const PlayedMotion&) = delete;

  [[nodiscard]] double duration() const { return way_.duration(); }

  [[nodiscard]] std::vector<double> at(double time_s, Time now) const {
    return way_.at(time_s, now);
  }

  /// Takes up what was edited. What is to be told of it; empty: nothing new.
  /// Errors: InvalidInput if the session is closed, or its hand another one; what the server
  /// said.
  std::string takeEdits(Time now);

 private:
  struct Found {
    std::uint64_t revision = 0;
    std::optional<JointInterpolation> way;
    std::exception_ptr trouble;
  };

  void look();
  Found lookOnce(std::uint64_t known);

  Client& server_;
  v1::SessionState session_;
  ChangingWay way_;
  std::mutex mutex_;
  std::condition_variable ends_;
  bool is_ending_ = false;
  std::optional<Found> found_;
  std::thread looking_;
};

}  // namespace handgraft::client
