#pragma once

#include <chrono>
#include <cstdint>

namespace handgraft::bridge {

/// Absolute deadlines of a loop, without a clock of its own. Periods lie on one grid: what is
/// late moves nothing that comes after, and what was missed is not made up for.
class Periodic {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  /// Errors: BrokenContract for a period that is not positive.
  explicit Periodic(Duration period);

  /// A period begins at `now`; when the next one is due.
  Time begin(Time now);

  /// The work was slow on purpose (motors switched on): the grid starts anew with the next
  /// `begin`, and nobody is late.
  void forgive() { is_new_ = true; }

  [[nodiscard]] std::uint64_t periods() const { return periods_; }

  /// Periods that began later than half a period.
  [[nodiscard]] std::uint64_t overruns() const { return overruns_; }

  [[nodiscard]] Duration worstLateness() const { return worst_lateness_; }

 private:
  Duration period_;
  Time due_{};
  bool is_new_ = true;  // the grid starts with the next period
  std::uint64_t periods_ = 0;
  std::uint64_t overruns_ = 0;
  Duration worst_lateness_{};
};

/// Sleeps until `time` of the steady clock, by an absolute deadline of the kernel's.
void sleepUntil(Periodic::Time time);

/// Real-time scheduling (SCHED_FIFO, `priority` 1 to 99) for the calling thread, and memory
/// that stays in place. False where that is not permitted; nothing has changed then.
bool becomeRealtime(int priority);

}  // namespace handgraft::bridge
