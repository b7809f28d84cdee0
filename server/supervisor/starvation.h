#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include <sys/types.h>

namespace handgraft::server {

/// How long another process' threads wait for a processor: one that does not get its turn gives
/// no answer either, and to start it again would help nobody.
class Starvation {
 public:
  explicit Starvation(pid_t process) : process_(process) {}

  /// The most that one of its threads waited since the last call; nothing at the first one, and
  /// where the kernel does not say.
  std::chrono::nanoseconds sinceLast();

 private:
  pid_t process_;
  std::map<std::string, std::int64_t> waited_ns_;  ///< each thread, in all
};

/// How long somebody was silent, as it counts against him: time in which he, or who listens,
/// did not get his turn does not; his own up to a limit, since a thread that spins for ever
/// waits for its turn, too.
class Silence {
 public:
  using Clock = std::chrono::steady_clock;

  Silence(Clock::duration most_forgiven, Clock::time_point now)
      : most_forgiven_(most_forgiven), since_(now) {}

  /// Something was heard, or is listened for from now on.
  void begin(Clock::time_point now) {
    since_ = now;
    forgiven_ = {};
  }

  /// Nobody listened for so long.
  void standStill(Clock::duration time) { since_ += time; }

  /// He waited for his turn for so long.
  void forgive(Clock::duration time) { forgiven_ = std::min(most_forgiven_, forgiven_ + time); }

  [[nodiscard]] Clock::duration lasts(Clock::time_point now) const {
    return now - since_ - forgiven_;
  }

 private:
  const Clock::duration most_forgiven_;
  Clock::time_point since_;
  Clock::duration forgiven_{};
};

}  // namespace handgraft::server
