#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>

/// When what is not answered is said again.
namespace handgraft::idl::cyclone {

/// How long answers take, as far as this client has seen: the time after which one is late
/// (Jacobson 1988; RFC 6298, section 2: smoothed mean and four times the mean deviation).
///
/// Why: a hundred clients on two processors, each of which said everything ten times in the
/// first half second, kept a server busy with repeats alone, so that it answered late, so that
/// all was repeated; none of that ended before they did (DECISIONS.md).
class AnswerTime {
 public:
  using Clock = std::chrono::steady_clock;
  using Duration = std::chrono::duration<double>;

  static constexpr std::chrono::milliseconds kLeast{50};  // measured to lose nothing
  static constexpr std::chrono::milliseconds kMost{1000};

  /// One came so long after it was asked for first. That of a repeat is taken for the first's:
  /// too long rather than too short.
  void add(Clock::duration took) {
    const Duration now = took;
    if (!known_) {
      mean_ = now;
      deviation_ = now / 2.0;
      known_ = true;
      return;
    }
    deviation_ = 0.75 * deviation_ + 0.25 * Duration(std::abs((now - mean_).count()));
    mean_ = 0.875 * mean_ + 0.125 * now;
  }

  /// Another server answers, by ways of its own.
  void forget() { known_ = false; }

  [[nodiscard]] Clock::duration lateAfter() const {
    if (!known_) return kLeast;
    const auto late = std::chrono::duration_cast<Clock::duration>(mean_ + 4.0 * deviation_);
    return std::clamp<Clock::duration>(late, kLeast, kMost);
  }

 private:
  bool known_ = false;
  Duration mean_{};
  Duration deviation_{};
};

/// When to say one thing again: soon while discovery settles, half as often each time after
/// that, and never so fast that a large body floods the wire.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr int kSoon = 3;  // times, before it slows down
  static constexpr std::chrono::milliseconds kSlow{2000};

  /// `late_after`: AnswerTime's.
  Pace(std::size_t bytes, Clock::duration late_after)
      : first_(late_after +
               std::chrono::milliseconds(static_cast<long>(bytes / kBytesPerMillisecond))),
        interval_(first_) {}

  [[nodiscard]] Clock::time_point next() const { return next_; }

  [[nodiscard]] Clock::duration interval() const { return interval_; }

  /// Said before, and not answered in time.
  [[nodiscard]] bool isRepeat() const { return count_ > 1; }

  void sent(Clock::time_point now) {
    if (++count_ > kSoon)
      interval_ = std::max(interval_, std::min<Clock::duration>(2 * interval_, kSlow));
    next_ = now + interval_;
  }

  /// The server is known to be at work on it.
  void slowDown() { interval_ = std::max<Clock::duration>(interval_, kAtWork); }

  void hurry() { next_ = Clock::time_point{}; }

  /// Whoever was asked is gone; at once, and as at first.
  void beginAnew() {
    count_ = 0;
    interval_ = first_;
    hurry();
  }

 private:
  static constexpr std::chrono::milliseconds kAtWork{1000};
  static constexpr std::size_t kBytesPerMillisecond =
      10'000;  // far below what loopback carries

  Clock::duration first_;
  Clock::duration interval_;
  Clock::time_point next_{};
  int count_ = 0;
};

}  // namespace handgraft::idl::cyclone
