#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "idl/sessions.h"

namespace handgraft::client {

/// When a demonstrator's frames were sent, and what came of them. From several threads.
class FollowAnswers {
 public:
  using Clock = std::chrono::steady_clock;

  /// `before`: what the session said before a frame was sent.
  explicit FollowAnswers(v1::FollowState before) : said_(std::move(before)) {}

  void sent(double time_s, Clock::time_point now);
  void came(const v1::PoseSolution& solution, Clock::time_point now);
  /// What the session says. That somebody else is followed refuses us where no frame of ours
  /// was answered and it is said still once whoever was followed before had time to stop; later
  /// yet it answers somebody else.
  void said(const v1::FollowState& state, Clock::time_point now);

  /// Why the server refused frames of ours; nothing: it did not.
  [[nodiscard]] std::optional<std::string> refusal() const;

  /// Why no frame was answered, as far as it is known.
  [[nodiscard]] std::string whyNone() const;

  /// ms; a share of all latencies lies below; NaN without any.
  [[nodiscard]] double latency(double share) const;
  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] double largestStep() const;

 private:
  mutable std::mutex mutex_;
  std::map<double, Clock::time_point> sent_;
  std::optional<Clock::time_point> begun_;
  std::vector<double> latency_ms_;
  std::vector<double> last_;
  double largest_step_ = 0.0;
  v1::FollowState said_;  // last
  bool is_news_ = false;
  std::optional<std::string> refusal_;
};

}  // namespace handgraft::client
