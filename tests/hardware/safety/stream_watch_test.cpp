#include "hardware/safety/stream_watch.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::safety {
namespace {

using namespace std::chrono_literals;
using Verdict = SampleVerdict;

const std::vector<std::string> watched_joints{"c", "a", "b"};
constexpr Time kStart{1h};

/// The sender's clock, of any origin.
std::int64_t sentAt(std::chrono::nanoseconds since_start) {
  return 1'700'000'000'000'000'000 + since_start.count();
}

Verdict see(StreamWatch& watch,
            std::uint64_t sequence,
            std::int64_t source_ns,
            Time now,
            std::uint64_t stream = 1) {
  return watch.see({stream, sequence, source_ns, watched_joints, std::vector{1.0, 2.0, 3.0}},
                   now);
}

TEST(StreamWatch, TakesJointsByNameInAnyOrder) {
  StreamWatch watch(watched_joints, 100ms);
  const std::vector<std::string> other{"a", "b", "c"};
  const std::vector<double> pose{10, 20, 30};
  for (std::uint64_t i = 1; i <= 2; ++i) {
    EXPECT_EQ(watch.see({1, i, 0, other, pose}, kStart), Verdict::kAccepted);
    EXPECT_EQ(watch.target(), (std::vector<double>{30, 10, 20}));
  }
  EXPECT_EQ(watch.see({1, 9, 0, watched_joints, pose}, kStart), Verdict::kAccepted);
  EXPECT_EQ(watch.target(), pose);
}

TEST(StreamWatch, RefusesNamesThatAreMissingTwiceOrUnknown) {
  StreamWatch watch(watched_joints, 100ms);
  const std::vector<double> pose{1, 2, 3};
  std::uint64_t number = 0;
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"a", "a", "b"}, {"a", "b", "d"}, {"a", "b", ""}}) {
    EXPECT_EQ(watch.see({1, ++number, 0, names, pose}, kStart), Verdict::kWrongNames);
    // The same again: a refused order must not have become the known one.
    EXPECT_EQ(watch.see({1, ++number, 0, names, pose}, kStart), Verdict::kWrongNames);
  }
  EXPECT_FALSE(watch.stream());
  EXPECT_EQ(watch.see({1, 1, 0, watched_joints, pose}, kStart), Verdict::kAccepted);
}

TEST(StreamWatch, IsFreshForTheStaleTimeAfterAnAcceptedPose) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_FALSE(watch.isFresh(kStart));
  see(watch, 1, 0, kStart);
  EXPECT_TRUE(watch.isFresh(kStart + 100ms));
  EXPECT_FALSE(watch.isFresh(kStart + 101ms));
  see(watch, 1, 0, kStart + 90ms);
  EXPECT_FALSE(watch.isFresh(kStart + 101ms)) << "a repeat proves nothing";
}

TEST(StreamWatch, CountsNumbersPerStream) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_EQ(see(watch, 7, 0, kStart), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 7, 0, kStart), Verdict::kRepeated);
  EXPECT_EQ(see(watch, 6, 0, kStart), Verdict::kLate);
  EXPECT_EQ(see(watch, 1, 0, kStart, 2), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 2, 0, kStart, 2), Verdict::kAccepted);
}

TEST(StreamWatch, RefusesPosesThatWereLongOnTheirWay) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_EQ(see(watch, 1, sentAt(0ms), kStart + 5ms), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 2, sentAt(10ms), kStart + 115ms), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 3, sentAt(20ms), kStart + 130ms), Verdict::kTooOld);
  EXPECT_EQ(see(watch, 4, sentAt(125ms), kStart + 131ms), Verdict::kAccepted);
}

TEST(StreamWatch, MeasuresAgainstTheQuickestWay) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_EQ(see(watch, 1, sentAt(0ms), kStart + 50ms), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 2, sentAt(60ms), kStart + 60ms), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 3, sentAt(61ms), kStart + 170ms), Verdict::kTooOld);
}

TEST(StreamWatch, FollowsASenderWhoseClockDrifts) {
  StreamWatch watch(watched_joints, 100ms);
  // 500 ppm slow for ten minutes: 300 ms.
  for (int i = 0; i < 6000; ++i) {
    const auto elapsed = std::chrono::microseconds(100'000LL * i);
    ASSERT_EQ(see(watch, i + 1, sentAt(elapsed - elapsed / 2000), kStart + elapsed),
              Verdict::kAccepted);
  }
}

TEST(StreamWatch, RefusesASenderWhoseClockRunsBackwardsUntilItIsForgotten) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_EQ(see(watch, 1, sentAt(1s), kStart), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 2, sentAt(0s), kStart + 10ms), Verdict::kBackwards);
  EXPECT_EQ(see(watch, 3, -1, kStart + 20ms), Verdict::kBackwards);
  watch.forgetClock();
  EXPECT_EQ(see(watch, 4, sentAt(0s), kStart + 30ms), Verdict::kAccepted);
}

TEST(StreamWatch, SurvivesTheLargestClock) {
  StreamWatch watch(watched_joints, 100ms);
  EXPECT_EQ(see(watch, 1, INT64_MAX, kStart), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 2, INT64_MAX, kStart + 10ms), Verdict::kAccepted);
  EXPECT_EQ(see(watch, 3, 1, kStart + 20ms), Verdict::kBackwards);
}

TEST(StreamWatch, RefusesNamesOfNoHand) {
  EXPECT_THROW(StreamWatch({}, 100ms), InvalidInput);
  EXPECT_THROW(StreamWatch({"a", "a"}, 100ms), InvalidInput);
  EXPECT_THROW(StreamWatch({""}, 100ms), InvalidInput);
}

}  // namespace
}  // namespace handgraft::safety
