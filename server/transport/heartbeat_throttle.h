#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>

namespace handgraft::server {

/// How often other participants are asked for acknowledgements. Fast DDS 2.9.1 asks every
/// reader that owes one at its writer's period (10 ms, fast_endpoints.h): also those of a
/// client that was killed, until its lease ends 20 s later, and, where a busy server answers
/// late, those of all at once, which makes it answer later still. Beside a hundred clients that
/// come, go and are killed, its threads did little else than wait for one another to send
/// these.
///
/// Threads: all methods from any. Cost: O(log participants).
class HeartbeatThrottle {
 public:
  using Clock = std::chrono::steady_clock;
  using Prefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUIDs

  /// Who lives answers a heartbeat at once; a busy machine or a slow network takes longer.
  static constexpr std::chrono::milliseconds kSilent{500};
  /// Who is silent is asked again after so long, by each writer, then after twice as long.
  static constexpr std::chrono::milliseconds kFirstPeriod{500};
  static constexpr std::chrono::milliseconds kLongestPeriod{4000};
  /// Of who is not, so many are asked as often as writers want; more of them share that, but
  /// for what discovery's writers ask, and for all that who has just come is asked.
  static constexpr std::size_t kFew = 10;
  static constexpr std::chrono::milliseconds kPeriodOfFew{10};
  static constexpr std::chrono::milliseconds kNew{300};

  /// A datagram came.
  void hear(std::span<const std::uint8_t> datagram, Clock::time_point now = Clock::now());

  /// True but of heartbeats, and nothing else, that would come too soon: for one participant,
  /// or for all of many and without a sample that was not told of before. Discovery's writers
  /// tell all whenever one comes, a hundred times a second where that many do, and are answered
  /// by each.
  bool maySend(std::span<const std::uint8_t> datagram, Clock::time_point now = Clock::now());

 private:
  struct Probe {
    Clock::time_point last;
    Clock::duration period{kFirstPeriod};  ///< before the next one, where he stays silent
  };

  struct Peer {
    Clock::time_point met;
    Clock::time_point heard;
    std::map<std::uint32_t, Probe> asked;  ///< by which writer
  };

  /// What a writer said to all last.
  struct Announced {
    Clock::time_point last;
    std::int64_t newest = 0;
  };

  /// Forgets who was not heard for longer than any lease, and counts; `mutex_` held.
  void tidy(Clock::time_point now);

  std::mutex mutex_;
  std::map<Prefix, Peer> peers_;
  std::map<std::uint32_t, Announced> announced_;  ///< by writers
  Clock::time_point tidied_{};
  std::size_t lively_ = 0;  ///< heard not long before that
};

}  // namespace handgraft::server
