#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hardware/safety/governor_types.h"

namespace handgraft::safety {

/// Decides which poses of a stream count, and whether the stream is fresh: our deadman.
///
/// Time is the receiver's monotonic clock. The sender's clock is only held against itself: it
/// must not run backwards, and a pose must not have been on its way longer by `stale_after`
/// than the quickest one. (The quickest grows by 1 ms a second, since clocks drift.)
///
/// Cost: O(joints) for names in the order of the last sample, O(joints log joints) else; no
/// allocation after construction.
class StreamWatch {
 public:
  /// Errors: InvalidInput for no joints, or a name that is empty or twice.
  StreamWatch(std::vector<std::string> names, Milliseconds stale_after);

  /// Checks in this order: finite, length, names, progress, the sender's clock. What is not
  /// accepted changes nothing.
  SampleVerdict see(const TargetSample& sample, Time now);

  /// The stream says that its newest pose still stands: counts as fresh, for streams that speak
  /// only when something changes. Passed over before the first pose and from other streams.
  void renew(std::uint64_t stream, Time now);

  /// The stream's newest pose moves on along timed samples, the newest of which came at
  /// `sampled`: it counts as an accepted pose of that moment. In the order of `names`. False,
  /// and nothing changes, before the first pose, for another stream, what is not finite or of
  /// another length.
  bool guide(std::uint64_t stream, std::span<const double> joint_rad, Time sampled);

  /// Forgets what is known of the sender's clock: after a pause it may have been set anew.
  void forgetClock();

  [[nodiscard]] bool isFresh(Time now) const;

  /// Since the newest accepted pose, renewals aside; empty before the first.
  [[nodiscard]] std::optional<Time::duration> age(Time now) const;

  /// Of the newest accepted pose; empty before the first.
  [[nodiscard]] std::optional<std::uint64_t> stream() const { return stream_; }

  /// The newest accepted pose, rad, in the order of `names`; zeros before the first.
  [[nodiscard]] const std::vector<double>& target() const { return target_; }

 private:
  bool findOrder(std::span<const std::string> names);
  [[nodiscard]] SampleVerdict clockVerdict(const TargetSample& sample,
                                           bool is_same_stream,
                                           Time now) const;
  void noteClock(std::int64_t source_ns, Time now);

  struct SenderClock {
    std::int64_t last_ns;
    std::int64_t least_offset_ns;  // receive time minus send time, of two clocks
    Time least_at;
  };

  std::vector<std::string> names_;
  std::vector<std::size_t> sorted_;  // of names_, for lookup
  std::vector<std::size_t> order_;   // sample index -> joint, as of the last sample
  std::vector<bool> taken_;
  Milliseconds stale_after_;

  std::optional<std::uint64_t> stream_;
  std::uint64_t sequence_ = 0;
  std::optional<SenderClock> clock_;
  Time accepted_at_{};
  Time fresh_at_{};
  std::vector<double> target_;
};

}  // namespace handgraft::safety
