#include "client/cli/commands/follow_answers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace handgraft::client {

namespace {

// Whoever was followed before may have stopped just now: a server waits for 500 ms.
constexpr std::chrono::milliseconds kOtherStops(750);
// Whoever is not refused until then is followed, and what is said later is of somebody else.
constexpr std::chrono::milliseconds kBeginning(2000);
// Refusals alone for longer are no glitch of a tracker.
constexpr std::chrono::milliseconds kGlitches(1000);

}  // namespace

void FollowAnswers::sent(double time_s, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (!begun_) begun_ = now;
  sent_[time_s] = {now, sent_count_++};
  sent_last_s_ = time_s;
}

void FollowAnswers::came(const v1::PoseSolution& solution, Clock::time_point now) {
  if (solution.time_s().empty()) return;
  const std::lock_guard lock(mutex_);
  const auto found = sent_.find(solution.time_s().front());
  if (found == sent_.end()) return;
  latency_ms_.push_back(
      std::chrono::duration<double, std::milli>(now - found->second.at).count());
  touching_ += solution.patches().empty() ? 0 : 1;
  const Last answer{found->second.number, solution.time_s().front(), solution.X_WH(),
                    solution.joint_positions()};
  sent_.erase(found);
  if (last_ && last_->joints.size() == answer.joints.size()) noteStep(*last_, answer);
  last_ = answer;
}

void FollowAnswers::noteStep(const Last& before, const Last& now) {
  if (now.number <= before.number) return;  // answers that overtook each other
  const auto frames = static_cast<double>(now.number - before.number);
  const double seconds = now.time_s - before.time_s;
  const bool is_first = latency_ms_.size() <= 2;
  for (std::size_t i = 0; i < now.joints.size(); ++i) {
    const double way = std::abs(now.joints[i] - before.joints[i]);
    if (way / frames > largest_step_.size) largest_step_ = {way / frames, i, now.time_s};
    if (!is_first && seconds > 0.0) largest_speed_ = std::max(largest_speed_, way / seconds);
  }
  const auto along = [&](std::size_t axis) {
    return now.X_WH.p_m()[axis] - before.X_WH.p_m()[axis];
  };
  const double way = std::hypot(along(0), along(1), along(2)) / frames;
  if (way > largest_root_step_.size) largest_root_step_ = {way, 0, now.time_s};
}

void FollowAnswers::said(const v1::FollowState& state, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  // What was said before the first frame answers somebody of before.
  is_news_ = is_news_ || state != said_;
  if (!is_news_) return;
  const bool is_told_again = is_refused_ && state == said_;
  is_refused_ = state.verdict() == v1::FOLLOW_REFUSED;
  if (state.verdict() == v1::FOLLOW_NOTHING_SAID) return;
  said_ = state;
  if (!begun_) return;
  if (state.verdict() == v1::FOLLOW_WAITS) {
    waiting_ = state.text();
    return;
  }
  if (is_refused_ && !is_told_again) {
    if (refusals_.count == 0) refusals_.first_s = sent_last_s_;
    ++refusals_.count;
  }
  if (refusal_) return;
  const Clock::duration since = now - *begun_;
  const bool is_ours = latency_ms_.empty() && since >= kOtherStops && since < kBeginning;
  if (state.verdict() == v1::FOLLOW_ANOTHER && !is_ours) return;
  refusal_ = state.text();
  another_is_followed_ = state.verdict() == v1::FOLLOW_ANOTHER;
}

std::optional<std::string> FollowAnswers::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

bool FollowAnswers::isHopeless(Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  if (!refusal_) return false;
  const bool is_all = latency_ms_.empty() && !waiting_ && now - *begun_ >= kGlitches;
  return another_is_followed_ || is_all;
}

FollowAnswers::Refusals FollowAnswers::refusals() const {
  const std::lock_guard lock(mutex_);
  return refusals_;
}

std::optional<std::string> FollowAnswers::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

std::string FollowAnswers::whyNone() const {
  const std::lock_guard lock(mutex_);
  return said_.text().empty() ? "the server says nothing of why" : said_.text();
}

double FollowAnswers::latency(double share) const {
  const std::lock_guard lock(mutex_);
  if (latency_ms_.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = latency_ms_;
  std::sort(sorted.begin(), sorted.end());
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(share * last)];
}

std::size_t FollowAnswers::count() const {
  const std::lock_guard lock(mutex_);
  return latency_ms_.size();
}

std::size_t FollowAnswers::touching() const {
  const std::lock_guard lock(mutex_);
  return touching_;
}

FollowAnswers::Step FollowAnswers::largestStep() const {
  const std::lock_guard lock(mutex_);
  return largest_step_;
}

FollowAnswers::Step FollowAnswers::largestRootStep() const {
  const std::lock_guard lock(mutex_);
  return largest_root_step_;
}

double FollowAnswers::largestSpeed() const {
  const std::lock_guard lock(mutex_);
  return largest_speed_;
}

}  // namespace handgraft::client
