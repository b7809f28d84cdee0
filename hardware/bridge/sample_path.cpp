#include "hardware/bridge/sample_path.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::bridge {

namespace {

using safety::SampleVerdict;
using safety::Time;

constexpr std::int64_t kSilenceNs = 250'000'000;  // from here on samples have paused
constexpr std::int64_t kMostBehindNs = 1'000'000'000;
constexpr std::int64_t kFirstIntervalNs = 10'000'000;  // until the interval is known
constexpr double kSlew = 0.1;                          // s; in which a delay is made up for
constexpr double kFastest = 1.5;                       // times real time, on the way
constexpr double kSlowest = 0.5;
// Of the last 64: three in a hundred may come later than the clock allows for.
constexpr std::size_t kLateRank = 2;

std::int64_t nanoseconds(Time time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

double seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace

SamplePath::SamplePath(std::size_t joint_count)
    : joint_count_(joint_count),
      joint_rad_(kMostSamples * joint_count),
      source_ns_(kMostSamples),
      pose_(joint_count),
      velocity_(joint_count) {
  HANDGRAFT_REQUIRE(joint_count > 0);
}

void SamplePath::clear() {
  first_ = count_ = learnt_ = 0;
  advanced_at_.reset();
  behind_s_ = 0;
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
}

// === The ring

std::size_t SamplePath::slotOf(std::size_t index) const {
  return (first_ + index) % kMostSamples;
}

std::span<double> SamplePath::joints(std::size_t index) {
  return std::span(joint_rad_).subspan(slotOf(index) * joint_count_, joint_count_);
}

std::int64_t& SamplePath::timeOf(std::size_t index) {
  return source_ns_[slotOf(index)];
}

void SamplePath::dropFirst() {
  first_ = slotOf(1);
  --count_;
}

void SamplePath::insert(std::size_t index,
                        std::int64_t source_ns,
                        std::span<const double> joint_rad) {
  if (count_ == kMostSamples) {
    dropFirst();
    ++skipped_;
    index = index > 0 ? index - 1 : 0;
  }
  ++count_;
  for (std::size_t i = count_ - 1; i > index; --i) {
    timeOf(i) = timeOf(i - 1);
    const std::span<double> before = joints(i - 1);
    std::copy(before.begin(), before.end(), joints(i).begin());
  }
  timeOf(index) = source_ns;
  std::copy(joint_rad.begin(), joint_rad.end(), joints(index).begin());
}

void SamplePath::append(std::int64_t source_ns, std::span<const double> joint_rad) {
  insert(count_, source_ns, joint_rad);
}

// === Samples

// Out of order, but not yet passed: it takes its place.
SampleVerdict SamplePath::insertByTime(std::int64_t source_ns,
                                       std::span<const double> joint_rad) {
  std::size_t index = count_;
  while (index > 0 && timeOf(index - 1) > source_ns)
    --index;
  if (index > 0 && timeOf(index - 1) == source_ns) return SampleVerdict::kRepeated;
  if (index == 0 || source_ns <= clock_ns_) return SampleVerdict::kLate;
  insert(index, source_ns, joint_rad);
  return SampleVerdict::kAccepted;
}

SampleVerdict SamplePath::add(std::int64_t source_ns,
                              std::span<const double> joint_rad,
                              bool continues,
                              Time arrived) {
  if (joint_rad.size() != joint_count_) return SampleVerdict::kWrongLength;
  for (const double value : joint_rad) {
    if (!std::isfinite(value)) return SampleVerdict::kNotFinite;
  }
  const bool is_first = count_ == 0;
  const bool paused =
      !is_first && !continues && nanoseconds(arrived) - nanoseconds(arrived_) > kSilenceNs;
  if (!is_first && !paused) {
    const std::int64_t gap = source_ns - timeOf(count_ - 1);
    if (gap < -kSilenceNs) return SampleVerdict::kBackwards;
    if (gap <= 0) {
      const SampleVerdict verdict = insertByTime(source_ns, joint_rad);
      if (verdict == SampleVerdict::kAccepted) arrived_ = arrived;
      return verdict;
    }
    if (continues || gap <= kSilenceNs) {
      if (!continues) learn(gap, source_ns, arrived);
      append(source_ns, joint_rad);
      arrived_ = arrived;
      return SampleVerdict::kAccepted;
    }
  }
  restart(source_ns, arrived);
  append(source_ns, joint_rad);
  if (is_first) std::copy(joint_rad.begin(), joint_rad.end(), pose_.begin());
  arrived_ = arrived;
  return SampleVerdict::kAccepted;
}

// From where the pose is now, within one interval, to the first sample of another time.
void SamplePath::restart(std::int64_t source_ns, Time arrived) {
  const bool has_pose = count_ > 0;
  first_ = count_ = learnt_ = 0;
  clock_ns_ = source_ns - kFirstIntervalNs;
  shift_ns_ = nanoseconds(arrived) - clock_ns_;
  if (has_pose) append(clock_ns_, pose_);
}

void SamplePath::learn(std::int64_t gap_ns, std::int64_t source_ns, Time arrived) {
  const std::size_t slot = learnt_++ % kWindow;
  lateness_ns_[slot] = nanoseconds(arrived) - source_ns;
  gap_ns_[slot] = gap_ns;
  const std::size_t known = std::min(learnt_, kWindow);
  std::array<std::int64_t, kWindow> sorted = gap_ns_;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(known);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(known / 2);
  std::nth_element(sorted.begin(), middle, end);
  const std::int64_t interval_ns = *middle;
  sorted = lateness_ns_;
  const auto late = end - 1 - static_cast<std::ptrdiff_t>(std::min(kLateRank, (known - 1) / 4));
  std::nth_element(sorted.begin(), late, end);
  shift_ns_ = *late + interval_ns;
}

// === The clock

std::span<const double> SamplePath::advance(Time now, double most_rate) {
  if (count_ == 0) return {};
  const double passed_s =
      advanced_at_ ? std::chrono::duration<double>(now - *advanced_at_).count() : 0.0;
  advanced_at_ = now;
  const std::int64_t newest_ns = timeOf(count_ - 1);
  const std::int64_t meant_ns = nanoseconds(now) - shift_ns_;
  const double ahead_s = seconds(meant_ns - clock_ns_) - passed_s;
  const double rate =
      std::min(std::clamp(1.0 + ahead_s / kSlew, kSlowest, kFastest), most_rate);
  clock_ns_ += static_cast<std::int64_t>(1e9 * rate * passed_s);
  // Where there is no next sample yet, the last one holds.
  clock_ns_ = std::min(clock_ns_, newest_ns);
  if (std::min(meant_ns, newest_ns) - clock_ns_ > kMostBehindNs) {
    clock_ns_ = std::min(meant_ns, newest_ns);
    for (std::size_t i = 1; i < count_ && timeOf(i) < clock_ns_; ++i)
      ++skipped_;
  }
  behind_s_ = std::max(0.0, seconds(std::min(meant_ns, newest_ns) - clock_ns_));
  while (count_ > 1 && timeOf(1) <= clock_ns_)
    dropFirst();
  interpolate();
  return pose_;
}

void SamplePath::interpolate() {
  const std::span<const double> from = joints(0);
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
  if (count_ == 1 || clock_ns_ <= timeOf(0)) {
    std::copy(from.begin(), from.end(), pose_.begin());
    return;
  }
  const std::span<const double> to = joints(1);
  const double interval_s = seconds(timeOf(1) - timeOf(0));
  const double share = seconds(clock_ns_ - timeOf(0)) / interval_s;
  for (std::size_t i = 0; i < joint_count_; ++i) {
    pose_[i] = from[i] + share * (to[i] - from[i]);
    velocity_[i] = (to[i] - from[i]) / interval_s;
  }
}

bool SamplePath::isPlaying(Time now) const {
  if (count_ == 0) return false;
  const bool comes = nanoseconds(now) - nanoseconds(arrived_) <= kSilenceNs;
  return comes || count_ > 1;
}

}  // namespace handgraft::bridge
