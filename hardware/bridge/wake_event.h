#pragma once

#include <atomic>
#include <cerrno>
#include <chrono>
#include <ctime>

#include <semaphore.h>

namespace handgraft::bridge {

/// Wakes the thread that waits at it: something has come, or a period is over. Who rings never
/// waits, locks or allocates. Threads: one waits, any ring.
class WakeEvent {
 public:
  WakeEvent() { sem_init(&rung_, 0, 0); }

  ~WakeEvent() { sem_destroy(&rung_); }

  WakeEvent(const WakeEvent&) = delete;
  WakeEvent& operator=(const WakeEvent&) = delete;

  /// Once is as good as often, until somebody has heard it.
  void ring() {
    if (!is_rung_.exchange(true)) sem_post(&rung_);
  }

  /// Until it rings, or has rung since it was last waited for; `most` at most.
  void wait(std::chrono::nanoseconds most) {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    constexpr long kSecondNs = 1'000'000'000;
    const long end_ns = until.tv_nsec + static_cast<long>(most.count() % kSecondNs);
    until.tv_sec += static_cast<std::time_t>(most.count() / kSecondNs + end_ns / kSecondNs);
    until.tv_nsec = end_ns % kSecondNs;
    while (sem_clockwait(&rung_, CLOCK_MONOTONIC, &until) != 0 && errno == EINTR) {
    }
    is_rung_.exchange(false);  // and see what was written before it rang
  }

 private:
  sem_t rung_{};
  std::atomic<bool> is_rung_{false};
};

}  // namespace handgraft::bridge
