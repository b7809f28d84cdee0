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

}  // namespace

void FollowAnswers::sent(double time_s, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (!begun_) begun_ = now;
  sent_[time_s] = now;
}

void FollowAnswers::came(const v1::PoseSolution& solution, Clock::time_point now) {
  if (solution.time_s().empty()) return;
  const std::lock_guard lock(mutex_);
  const auto found = sent_.find(solution.time_s().front());
  if (found == sent_.end()) return;
  latency_ms_.push_back(std::chrono::duration<double, std::milli>(now - found->second).count());
  sent_.erase(found);
  double step = 0.0;
  const std::vector<double>& joints = solution.joint_positions();
  for (std::size_t i = 0; i < joints.size() && last_.size() == joints.size(); ++i)
    step = std::max(step, std::abs(joints[i] - last_[i]));
  largest_step_ = std::max(largest_step_, step);
  last_ = joints;
}

void FollowAnswers::said(const v1::FollowState& state, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  // What was said before the first frame answers somebody of before.
  is_news_ = is_news_ || state != said_;
  const bool says_nothing = state.verdict() == v1::FOLLOW_NOTHING_SAID;
  if (!is_news_ || says_nothing) return;
  said_ = state;
  if (!begun_ || refusal_ || state.verdict() == v1::FOLLOW_WAITS) return;
  const Clock::duration since = now - *begun_;
  const bool is_ours = latency_ms_.empty() && since >= kOtherStops && since < kBeginning;
  if (state.verdict() == v1::FOLLOW_ANOTHER && !is_ours) return;
  refusal_ = state.text();
}

std::optional<std::string> FollowAnswers::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
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

double FollowAnswers::largestStep() const {
  const std::lock_guard lock(mutex_);
  return largest_step_;
}

}  // namespace handgraft::client
