// What two threads hand to each other, and when periods are due.

#include <thread>

#include <gtest/gtest.h>

#include "hardware/bridge/command_filter.h"
#include "hardware/bridge/periodic.h"
#include "hardware/bridge/request_ring.h"
#include "hardware/bridge/triple_buffer.h"

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using std::chrono::milliseconds;

TEST(TripleBuffer, TheNewestWinsAndIsTakenOnce) {
  TripleBuffer<int> value(0);
  EXPECT_EQ(value.take(), nullptr);
  for (const int i : {1, 2, 3}) {
    value.draft() = i;
    value.publish();
  }
  ASSERT_NE(value.take(), nullptr);
  EXPECT_EQ(value.last(), 3);
  EXPECT_EQ(value.take(), nullptr);
  EXPECT_EQ(value.last(), 3);
}

TEST(TripleBuffer, NothingIsTornBetweenThreads) {
  using Pair = std::array<std::uint64_t, 32>;
  TripleBuffer<Pair> value(Pair{});
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      value.draft().fill(i);
      value.publish();
    }
  });
  std::uint64_t seen = 0;
  while (seen != kLast) {
    const Pair* taken = value.take();
    if (taken == nullptr) continue;
    for (const std::uint64_t each : *taken)
      ASSERT_EQ(each, taken->front());
    ASSERT_GT(taken->front(), seen) << "never an older one after a newer one";
    seen = taken->front();
  }
  writer.join();
}

TEST(RequestRing, KeepsTheOrderAndRefusesWhenItIsFull) {
  RequestRing ring;
  EXPECT_FALSE(ring.take());
  for (int i = 0; i < 64; ++i)
    EXPECT_TRUE(ring.put(i % 2 == 0 ? Request::kArm : Request::kDisarm));
  EXPECT_FALSE(ring.put(Request::kReset));
  for (int i = 0; i < 64; ++i)
    EXPECT_EQ(ring.take(), i % 2 == 0 ? Request::kArm : Request::kDisarm);
  EXPECT_FALSE(ring.take());
  EXPECT_TRUE(ring.put(Request::kReset));
  EXPECT_EQ(ring.take(), Request::kReset);
}

TEST(Periodic, DeadlinesLieOnOneGridHoweverLateAPeriodIs) {
  Periodic periodic(milliseconds(10));
  const Periodic::Time start{milliseconds(5000)};
  EXPECT_EQ(periodic.begin(start), start + milliseconds(10));
  EXPECT_EQ(periodic.begin(start + milliseconds(14)), start + milliseconds(20));
  EXPECT_EQ(periodic.overruns(), 0) << "4 ms of 10 are not late";
  EXPECT_EQ(periodic.begin(start + milliseconds(26)), start + milliseconds(30));
  EXPECT_EQ(periodic.overruns(), 1);
  EXPECT_EQ(periodic.begin(start + milliseconds(95)), start + milliseconds(100))
      << "what was missed is not made up for";
  EXPECT_EQ(periodic.overruns(), 2);
  EXPECT_EQ(periodic.worstLateness(), milliseconds(65));
  EXPECT_EQ(periodic.periods(), 4);
}

TEST(Periodic, WhatIsSlowOnPurposeStartsTheGridAnew) {
  Periodic periodic(milliseconds(10));
  const Periodic::Time start{milliseconds(5000)};
  periodic.begin(start);
  periodic.forgive();
  EXPECT_EQ(periodic.begin(start + milliseconds(473)), start + milliseconds(483));
  EXPECT_EQ(periodic.overruns(), 0);
}

TEST(Periodic, SleepsUntilAMomentThatHasPassedAtOnce) {
  sleepUntil(std::chrono::steady_clock::now() - milliseconds(100));
  const auto until = std::chrono::steady_clock::now() + milliseconds(20);
  sleepUntil(until);
  EXPECT_GE(std::chrono::steady_clock::now(), until);
}

TEST(CommandFilter, LetsACommandThroughOnceAndAnEmergencyStopAlways) {
  CommandFilter filter(7);
  EXPECT_FALSE(filter.passes(test::command(1, v1::COMMAND_ARM, 8))) << "of another bridge";
  EXPECT_TRUE(filter.passes(test::command(1, v1::COMMAND_ARM, 7)));
  EXPECT_FALSE(filter.passes(test::command(1, v1::COMMAND_ARM, 7)));
  EXPECT_TRUE(filter.passes(test::command(1, v1::COMMAND_ESTOP, 7)));
  EXPECT_TRUE(filter.passes(test::command(2, v1::COMMAND_ARM, 7)));
  for (std::uint64_t id = 10; id < 2000; ++id)
    EXPECT_TRUE(filter.passes(test::command(id, v1::COMMAND_DISARM, 7)));
}

}  // namespace
}  // namespace handgraft::bridge
