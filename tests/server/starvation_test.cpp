// When a supervisor has waited long enough.
#include "server/supervisor/starvation.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

namespace handgraft::server {
namespace {

using std::chrono::milliseconds;

TEST(Silence, CountsNoTimeInWhichNobodyHadAProcessor) {
  const Silence::Clock::time_point begin{std::chrono::hours(1)};
  Silence silence(milliseconds(2000), begin);
  silence.standStill(milliseconds(700));
  silence.forgive(milliseconds(500));
  EXPECT_EQ(silence.lasts(begin + milliseconds(3000)), milliseconds(1800));
  // Who never gets anywhere, though his turn comes, is not waited for without end.
  silence.forgive(milliseconds(60'000));
  EXPECT_EQ(silence.lasts(begin + milliseconds(5000)), milliseconds(2300));
  silence.begin(begin + milliseconds(5000));
  EXPECT_EQ(silence.lasts(begin + milliseconds(5500)), milliseconds(500));
}

TEST(Starvation, IsWhatAThreadWaitsForItsTurn) {
  Starvation starvation(getpid());
  EXPECT_EQ(starvation.sinceLast().count(), 0) << "nothing to compare with yet";
  // Two threads on one processor: one of them waits whenever the other one runs.
  std::atomic<bool> stops{false};
  std::vector<std::thread> rivals;
  for (int i = 0; i < 2; ++i) {
    rivals.emplace_back([&] {
      cpu_set_t one;
      CPU_ZERO(&one);
      CPU_SET(0, &one);
      sched_setaffinity(0, sizeof one, &one);
      while (!stops) {
      }
    });
  }
  std::chrono::nanoseconds waited{0};
  for (int i = 0; i < 600 && waited < milliseconds(20); ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    waited += starvation.sinceLast();
  }
  stops = true;
  for (std::thread& one : rivals)
    one.join();
  EXPECT_GE(waited, milliseconds(20));
}

TEST(Starvation, IsNothingOfAProcessThatIsGone) {
  constexpr pid_t kNobody = 1 << 22;  // the kernel gives no higher one
  Starvation starvation(kNobody);
  EXPECT_EQ(starvation.sinceLast().count(), 0);
  EXPECT_EQ(starvation.sinceLast().count(), 0);
}

}  // namespace
}  // namespace handgraft::server
