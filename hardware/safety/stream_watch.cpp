#include "hardware/safety/stream_watch.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace handgraft::safety {

namespace {

// Quartz drifts by less than 100 ppm; ten times that.
constexpr std::int64_t kDriftDivisor = 1000;

std::int64_t nanosecondsOf(Time time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

}  // namespace

StreamWatch::StreamWatch(std::vector<std::string> names, Milliseconds stale_after)
    : names_(std::move(names)), stale_after_(stale_after) {
  if (names_.empty()) rejectInput("a hand without joints cannot be moved");
  sorted_.resize(names_.size());
  std::iota(sorted_.begin(), sorted_.end(), std::size_t{0});
  std::sort(sorted_.begin(), sorted_.end(), [this](std::size_t a, std::size_t b) {
    return names_[a] < names_[b];
  });
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::string& name = names_[sorted_[i]];
    if (name.empty() || (i > 0 && name == names_[sorted_[i - 1]]))
      rejectInput("joint name {} is empty or twice", quoted(name));
  }
  order_.resize(names_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  taken_.resize(names_.size());
  target_.resize(names_.size());
}

SampleVerdict StreamWatch::see(const TargetSample& sample, Time now) {
  for (const double value : sample.joint_rad) {
    if (!std::isfinite(value)) return SampleVerdict::kNotFinite;
  }
  if (sample.joint_rad.size() != names_.size() || sample.names.size() != names_.size())
    return SampleVerdict::kWrongLength;
  if (!findOrder(sample.names)) return SampleVerdict::kWrongNames;
  const bool is_same_stream = stream_ == sample.stream;
  if (is_same_stream && sample.sequence == sequence_) return SampleVerdict::kRepeated;
  if (is_same_stream && sample.sequence < sequence_) return SampleVerdict::kLate;
  const SampleVerdict verdict = clockVerdict(sample, is_same_stream, now);
  if (verdict != SampleVerdict::kAccepted) return verdict;

  if (!is_same_stream) clock_.reset();
  if (sample.source_ns != 0) noteClock(sample.source_ns, now);
  stream_ = sample.stream;
  sequence_ = sample.sequence;
  accepted_at_ = fresh_at_ = now;
  for (std::size_t i = 0; i < order_.size(); ++i)
    target_[order_[i]] = sample.joint_rad[i];
  return SampleVerdict::kAccepted;
}

// The order of the last sample nearly always is that of the next.
bool StreamWatch::findOrder(std::span<const std::string> names) {
  bool is_known = true;
  for (std::size_t i = 0; i < names.size() && is_known; ++i)
    is_known = names_[order_[i]] == names[i];
  if (is_known) return true;
  // Any failure leaves an order in which each joint is found once, else the shortcut would lie.
  const auto fail = [this] {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    return false;
  };
  std::fill(taken_.begin(), taken_.end(), false);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), names[i],
                                        [this](std::size_t joint, const std::string& name) {
                                          return names_[joint] < name;
                                        });
    if (found == sorted_.end() || names_[*found] != names[i] || taken_[*found]) return fail();
    taken_[*found] = true;
    order_[i] = *found;
  }
  return true;
}

SampleVerdict StreamWatch::clockVerdict(const TargetSample& sample,
                                        bool is_same_stream,
                                        Time now) const {
  if (sample.source_ns < 0) return SampleVerdict::kBackwards;
  if (sample.source_ns == 0 || !is_same_stream || !clock_) return SampleVerdict::kAccepted;
  if (sample.source_ns < clock_->last_ns) return SampleVerdict::kBackwards;
  const std::int64_t least =
      clock_->least_offset_ns + nanosecondsOf(Time(now - clock_->least_at)) / kDriftDivisor;
  const std::int64_t extra = nanosecondsOf(now) - sample.source_ns - least;
  const auto patience = std::chrono::duration_cast<std::chrono::nanoseconds>(stale_after_);
  return extra > patience.count() ? SampleVerdict::kTooOld : SampleVerdict::kAccepted;
}

void StreamWatch::noteClock(std::int64_t source_ns, Time now) {
  const std::int64_t offset = nanosecondsOf(now) - source_ns;
  if (!clock_) {
    clock_ = SenderClock{source_ns, offset, now};
    return;
  }
  clock_->last_ns = source_ns;
  const std::int64_t least =
      clock_->least_offset_ns + nanosecondsOf(Time(now - clock_->least_at)) / kDriftDivisor;
  if (offset <= least) {
    clock_->least_offset_ns = offset;
    clock_->least_at = now;
  }
}

void StreamWatch::renew(std::uint64_t stream, Time now) {
  if (stream_ == stream) fresh_at_ = std::max(fresh_at_, now);
}

bool StreamWatch::guide(std::uint64_t stream, std::span<const double> joint_rad, Time sampled) {
  if (stream_ != stream || joint_rad.size() != target_.size()) return false;
  if (!std::all_of(joint_rad.begin(), joint_rad.end(), [](double q) {
        return std::isfinite(q);
      }))
    return false;
  std::copy(joint_rad.begin(), joint_rad.end(), target_.begin());
  accepted_at_ = std::max(accepted_at_, sampled);
  fresh_at_ = std::max(fresh_at_, sampled);
  return true;
}

void StreamWatch::forgetClock() {
  clock_.reset();
}

bool StreamWatch::isFresh(Time now) const {
  return stream_.has_value() && now - fresh_at_ <= stale_after_;
}

std::optional<Time::duration> StreamWatch::age(Time now) const {
  if (!stream_) return std::nullopt;
  return now - accepted_at_;
}

}  // namespace handgraft::safety
