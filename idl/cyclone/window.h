#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace handgraft::idl::cyclone {

/// How many calls may be under way at once: as many as are answered before they must be said
/// again. It begins small, has one more for each answer, then one more for a whole window of
/// them, and is halved when one has to be repeated (Jacobson 1988, congestion avoidance): so
/// a client finds its part of a server that many ask, and does not drown it in repeats.
class Window {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t kFirst = 32;
  static constexpr std::size_t kLeast = 4;

  explicit Window(std::size_t most) : most_(most), threshold_(static_cast<double>(most)) {}

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(size_); }

  void answered() {
    size_ += size_ < threshold_ ? 1.0 : 1.0 / size_;
    size_ = std::min(size_, static_cast<double>(most_));
  }

  /// What is repeated within one `interval` was lost by one and the same crowd.
  void repeated(Clock::time_point now, Clock::duration interval) {
    if (now - halved_ < interval) return;
    halved_ = now;
    threshold_ = std::max(size_ / 2.0, static_cast<double>(kLeast));
    size_ = threshold_;
  }

 private:
  const std::size_t most_;
  double size_ = kFirst;
  double threshold_;
  Clock::time_point halved_{};
};

}  // namespace handgraft::idl::cyclone
