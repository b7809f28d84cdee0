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

  /// Why the server refused frames of ours, the first time; nothing: it did not.
  [[nodiscard]] std::optional<std::string> refusal() const;

  /// Whether there is no use in sending more: nothing but refusals for the first second, or
  /// somebody else is followed. Single frames may be a tracker's glitches.
  [[nodiscard]] bool isHopeless(Clock::time_point now) const;

  struct Refusals {
    int count = 0;         ///< as often as one was told; frames refused in a row for one reason
                           ///< count once
    double first_s = 0.0;  ///< time of the frame sent last before the first was told
  };

  [[nodiscard]] Refusals refusals() const;

  /// What the hand waited for last while it had no pose; nothing: it did not.
  [[nodiscard]] std::optional<std::string> waiting() const;

  /// Why no frame was answered, as far as it is known.
  [[nodiscard]] std::string whyNone() const;

  /// ms; a share of all latencies lies below; NaN without any.
  [[nodiscard]] double latency(double share) const;
  [[nodiscard]] std::size_t count() const;
  /// Answers to frames in which a part of the hand shows what the demonstrator touches.
  [[nodiscard]] std::size_t touching() const;

  /// How far a joint, or the root in W, goes from one answer to the next: a frame, on average,
  /// where some between them had no answer.
  struct Step {
    double size = 0.0;  ///< rad or m; 0: none goes anywhere
    std::size_t joint = 0;
    double time_s = 0.0;  ///< of the frame that it ends with
  };

  [[nodiscard]] Step largestStep() const;
  [[nodiscard]] Step largestRootStep() const;  ///< m
  /// Of any step but the first, by which the hand begins (rad/s or m/s); 0 without any.
  [[nodiscard]] double largestSpeed() const;

 private:
  mutable std::mutex mutex_;

  /// A frame that waits for its answer.
  struct Sent {
    Clock::time_point at;
    std::size_t number;
  };

  std::map<double, Sent> sent_;
  std::size_t sent_count_ = 0;
  std::optional<Clock::time_point> begun_;
  std::vector<double> latency_ms_;
  std::size_t touching_ = 0;

  /// What was answered last.
  struct Last {
    std::size_t number;
    double time_s;
    v1::Pose X_WH;
    std::vector<double> joints;
  };

  /// Under the lock.
  void noteStep(const Last& before, const Last& now);

  std::optional<Last> last_;
  Step largest_step_;
  Step largest_root_step_;
  double largest_speed_ = 0.0;
  v1::FollowState said_;  // last
  bool is_news_ = false;
  bool is_refused_ = false;  // as it was said last
  std::optional<std::string> refusal_;
  Refusals refusals_;
  double sent_last_s_ = 0.0;
  std::optional<std::string> waiting_;
  bool another_is_followed_ = false;
};

}  // namespace handgraft::client
