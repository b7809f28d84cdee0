#include "hardware/bridge/periodic.h"

#include <algorithm>
#include <cerrno>
#include <ctime>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include "core/base/error.h"

namespace handgraft::bridge {

Periodic::Periodic(Duration period) : period_(period) {
  HANDGRAFT_REQUIRE(period > Duration::zero());
}

Periodic::Time Periodic::begin(Time now) {
  if (is_new_) due_ = now;
  is_new_ = false;
  ++periods_;
  const Duration lateness = std::max(now - due_, Duration::zero());
  worst_lateness_ = std::max(worst_lateness_, lateness);
  if (2 * lateness > period_) ++overruns_;
  due_ += period_;
  if (due_ <= now) due_ += ((now - due_) / period_ + 1) * period_;
  return due_;
}

void sleepUntil(Periodic::Time time) {
  using std::chrono::nanoseconds;
  using std::chrono::seconds;
  const auto since = std::chrono::duration_cast<nanoseconds>(time.time_since_epoch());
  const auto whole = std::chrono::duration_cast<seconds>(since);
  timespec until{};
  until.tv_sec = static_cast<std::time_t>(whole.count());
  until.tv_nsec = static_cast<long>((since - whole).count());
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

bool becomeRealtime(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0) return false;
  // A page that has to be fetched costs milliseconds; where it may not be locked we go without.
  static_cast<void>(mlockall(MCL_CURRENT | MCL_FUTURE));
  return true;
}

}  // namespace handgraft::bridge
