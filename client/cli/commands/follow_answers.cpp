#include "client/cli/commands/follow_answers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "idl/demonstrator_words.h"

namespace handgraft::client {

namespace {

// Whoever was followed before may have stopped just now: a server waits for 500 ms.
constexpr std::chrono::milliseconds kOtherStops(750);
// Whoever is not refused until then is followed, and what is said later is of somebody else.
constexpr std::chrono::milliseconds kBeginning(2000);

/// What a session's message says of its demonstrator; empty: nothing.
std::string ofDemonstrator(const std::string& message) {
  const std::size_t at = message.find(idl::kOfDemonstrator);
  return at == std::string::npos ? "" : message.substr(at);
}

bool says(const std::string& word, std::string_view what) {
  const std::size_t begin = std::string_view(idl::kOfDemonstrator).size();
  return word.size() > begin && std::string_view(word).substr(begin).starts_with(what);
}

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

void FollowAnswers::said(const std::string& message, Clock::time_point now) {
  const std::string word = ofDemonstrator(message);
  const std::lock_guard lock(mutex_);
  // What was said before the first frame answers somebody of before.
  is_news_ = is_news_ || word != ofDemonstrator(said_);
  if (!is_news_) return;
  if (!word.empty()) said_ = word;
  if (!begun_ || word.empty() || refusal_ || says(word, idl::kTouchesTooLittle)) return;
  const Clock::duration since = now - *begun_;
  const bool is_ours = latency_ms_.empty() && since >= kOtherStops && since < kBeginning;
  if (says(word, idl::kAnotherIsFollowed) && !is_ours) return;
  refusal_ = word;
}

std::optional<std::string> FollowAnswers::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

std::string FollowAnswers::whyNone() const {
  const std::lock_guard lock(mutex_);
  const std::string word = ofDemonstrator(said_);
  return word.empty() ? "the server says nothing of why" : word;
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
