// When what is not answered is said again.
#include "idl/cyclone/pace.h"

#include <gtest/gtest.h>

namespace handgraft::idl::cyclone {
namespace {

using std::chrono::milliseconds;

/// How often something is said in so long.
int said(Pace pace, milliseconds time) {
  int count = 0;
  const Pace::Clock::time_point begin{std::chrono::hours(1)};
  for (Pace::Clock::time_point now = begin; now < begin + time; now = pace.next()) {
    pace.sent(now);
    ++count;
  }
  return count;
}

TEST(AnswerTime, IsShortBeforeAnythingIsKnown) {
  EXPECT_EQ(AnswerTime().lateAfter(), AnswerTime::kLeast);
}

TEST(AnswerTime, FollowsWhatAnswersTake) {
  AnswerTime time;
  for (int i = 0; i < 100; ++i)
    time.add(milliseconds(400));
  EXPECT_NEAR(std::chrono::duration<double>(time.lateAfter()).count(), 0.4, 0.01);
  time.add(milliseconds(900));
  EXPECT_GT(time.lateAfter(), milliseconds(800)) << "who varies is waited for longer";
  for (int i = 0; i < 100; ++i)
    time.add(milliseconds(1));
  EXPECT_EQ(time.lateAfter(), AnswerTime::kLeast);
}

TEST(AnswerTime, IsBoundedAndForgets) {
  AnswerTime time;
  time.add(std::chrono::hours(1));
  EXPECT_EQ(time.lateAfter(), AnswerTime::kMost);
  time.forget();
  EXPECT_EQ(time.lateAfter(), AnswerTime::kLeast);
}

TEST(Pace, IsSoonAtFirstAndThenEverSlower) {
  const Pace pace(100, AnswerTime::kLeast);
  EXPECT_EQ(said(pace, milliseconds(200)), 4);
  EXPECT_LE(said(pace, milliseconds(10'000)), 13);
}

TEST(Pace, WaitsForAServerThatIsKnownToTakeLong) {
  EXPECT_EQ(said(Pace(100, milliseconds(800)), milliseconds(800)), 1);
  EXPECT_EQ(said(Pace(100, milliseconds(800)), milliseconds(1600)), 2);
}

TEST(Pace, BeginsAnewForAnotherServer) {
  Pace pace(100, AnswerTime::kLeast);
  const Pace::Clock::time_point now{std::chrono::hours(1)};
  for (int i = 0; i < 20; ++i)
    pace.sent(now);
  EXPECT_EQ(pace.interval(), Pace::kSlow);
  pace.beginAnew();
  EXPECT_LE(pace.next(), now);
  EXPECT_EQ(pace.interval(), AnswerTime::kLeast);
}

}  // namespace
}  // namespace handgraft::idl::cyclone
