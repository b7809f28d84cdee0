#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hardware/safety/governor_types.h"

namespace handgraft::bridge {

/// Timed samples of a hand's joints, and a clock that goes along them: at any time the pose
/// between the two samples about it, so that a hand can be guided by samples that come at a
/// rate of their own.
///
/// The clock runs one usual interval behind the samples as they come, so that the next one is
/// there when it is needed; how late they come is learnt. A sample that is missing holds the
/// pose at the last one, and what comes then is followed from there, a little faster until the
/// delay is as before: the pose never jumps. After a silence the way goes straight on to the
/// first sample after it. What is more than a second behind is passed over.
///
/// Nothing allocates after construction. Not thread-safe.
class SamplePath {
 public:
  static constexpr std::size_t kMostSamples = 4096;

  explicit SamplePath(std::size_t joint_count);

  /// Forgets all samples.
  void clear();

  /// A sample as it came. `source_ns`: on the sender's clock. `continues`: of the same message
  /// as the one before, however much later it is to be reached. What is not accepted changes
  /// nothing: not finite, of another length, the same time again, a time that was passed
  /// already (late), or one far behind the newest (backwards), until the samples have paused.
  safety::SampleVerdict add(std::int64_t source_ns,
                            std::span<const double> joint_rad,
                            bool continues,
                            safety::Time arrived);

  /// Moves the clock on to `now`; `most_rate`: no faster than this many times real time. The
  /// pose, rad, valid until the next call; empty before the first sample.
  std::span<const double> advance(safety::Time now, double most_rate);

  /// The speeds, rad/s, at which the samples about the clock ask each joint to move in real
  /// time; zeros where they pause.
  [[nodiscard]] std::span<const double> velocity() const { return velocity_; }

  /// Samples come, or there are some not yet reached.
  [[nodiscard]] bool isPlaying(safety::Time now) const;

  /// When the newest sample came.
  [[nodiscard]] safety::Time newestArrival() const { return arrived_; }

  /// How far the clock is behind where it is meant to be, s.
  [[nodiscard]] double behind() const { return behind_s_; }

  /// Samples that were passed over because the clock was too far behind, or too many came.
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

 private:
  static constexpr std::size_t kWindow = 64;

  [[nodiscard]] std::span<double> joints(std::size_t index);
  [[nodiscard]] std::size_t slotOf(std::size_t index) const;
  [[nodiscard]] std::int64_t& timeOf(std::size_t index);
  void append(std::int64_t source_ns, std::span<const double> joint_rad);
  void insert(std::size_t index, std::int64_t source_ns, std::span<const double> joint_rad);
  safety::SampleVerdict insertByTime(std::int64_t source_ns, std::span<const double> joint_rad);
  void dropFirst();
  void restart(std::int64_t source_ns, safety::Time arrived);
  void learn(std::int64_t gap_ns, std::int64_t source_ns, safety::Time arrived);
  void interpolate();

  std::size_t joint_count_;
  std::vector<double> joint_rad_;  // a ring of samples, rising in time
  std::vector<std::int64_t> source_ns_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;

  std::int64_t clock_ns_ = 0;  // on the sender's clock: where the pose is now
  std::int64_t shift_ns_ = 0;  // of this machine's clock against where the pose is meant to be
  std::optional<safety::Time> advanced_at_;
  safety::Time arrived_{};

  // The last arrivals: how late each was by the two clocks, and after which interval.
  std::array<std::int64_t, kWindow> lateness_ns_{};
  std::array<std::int64_t, kWindow> gap_ns_{};
  std::size_t learnt_ = 0;

  std::vector<double> pose_;
  std::vector<double> velocity_;
  double behind_s_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace handgraft::bridge
