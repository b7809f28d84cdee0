#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "idl/sessions.h"

namespace handgraft::server {

/// How soon a change is told: at once; or not before so much time has passed since the last
/// telling; or never by itself. What is not told goes with the next that is.
struct PublishPolicy {
  std::optional<std::chrono::milliseconds> least_period;
};

/// A session's state, and the telling of it: each change that differs, in order, and never
/// while the lock is held that those wait for who ask for the state.
///
/// Threads: all methods from any thread; `publish` may ask for the state, and must not change
/// it.
class PublishedState {
 public:
  using Clock = std::chrono::steady_clock;
  using Now = std::function<Clock::time_point()>;
  using Publish = std::function<void(const v1::SessionState&)>;
  using Change = std::function<void(v1::SessionState&)>;

  static constexpr PublishPolicy kAtOnce{std::chrono::milliseconds(0)};
  static constexpr PublishPolicy kSilently{std::nullopt};

  PublishedState(Publish publish, Now now)
      : publish_(std::move(publish)), now_(std::move(now)) {}

  [[nodiscard]] v1::SessionState get() const;
  [[nodiscard]] bool isClosed() const;

  /// `change` runs with the lock held. Nothing follows PHASE_CLOSED.
  void change(const Change& change, PublishPolicy telling = kAtOnce);

 private:
  /// Publishes what waits.
  void publishQueued();

  const Publish publish_;
  const Now now_;

  mutable std::mutex mutex_;
  v1::SessionState state_;
  std::optional<v1::SessionState> told_;  ///< last, or about to be
  Clock::time_point told_at_{};
  std::deque<v1::SessionState> queued_;  ///< to be published

  std::mutex publishing_;  ///< for the order; nobody who wants to know the state waits for it
};

}  // namespace handgraft::server
