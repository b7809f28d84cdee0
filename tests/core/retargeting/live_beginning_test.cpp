#include "core/retargeting/live_beginning.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::retargeting {
namespace {

using Frames = std::vector<std::pair<double, int>>;  // time in s, touches

/// When it is due first.
std::optional<double> dueIn(const Frames& frames, int digits = 3) {
  LiveBeginning beginning;
  for (const auto& [time_s, touches] : frames)
    if (beginning.isDue(time_s, touches, digits)) return time_s;
  return std::nullopt;
}

/// At 100 Hz; `touches` by time in s.
template <class Touches>
Frames framesOf(double seconds, const Touches& touches) {
  Frames frames;
  for (int k = 0; k <= 100 * seconds; ++k)
    frames.emplace_back(0.01 * k, touches(0.01 * k));
  return frames;
}

TEST(LiveBeginning, WaitsForWhatComesAtOnce) {
  // Three at 0.5 s, and one more every 20 ms until there are six at 0.56 s.
  const auto due = dueIn(framesOf(2.0, [](double t) {
    return t < 0.495 ? 0 : t < 0.515 ? 3 : t < 0.535 ? 4 : t < 0.555 ? 5 : 6;
  }));
  ASSERT_TRUE(due);
  EXPECT_NEAR(*due, 0.64, 0.0101);
}

TEST(LiveBeginning, WaitsNoLongerThanAQuarterOfASecond) {
  const auto due = dueIn(framesOf(2.0, [](double t) {
    return t < 0.495 ? 0 : 3 + static_cast<int>((t - 0.495) / 0.03);
  }));
  ASSERT_TRUE(due);
  EXPECT_NEAR(*due, 0.75, 0.0101);
}

TEST(LiveBeginning, SlowFramesAreNotWaitedFor) {
  EXPECT_EQ(dueIn({{0.0, 0}, {0.1, 7}, {0.2, 7}}), 0.1);
  EXPECT_EQ(dueIn({{0.0, 0}, {0.05, 7}, {0.1, 7}, {0.15, 7}}), 0.15);
}

// A grasp takes two.
TEST(LiveBeginning, OfOneFingerAloneWaitsAQuarterOfASecond) {
  const Frames frames = framesOf(2.0, [](double t) {
    return t < 0.495 ? 0 : 3;
  });
  EXPECT_NEAR(dueIn(frames, 2).value_or(0.0), 0.58, 0.0101);
  EXPECT_NEAR(dueIn(frames, 1).value_or(0.0), 0.75, 0.0101);
}

// Two fingers, each with its tip; three begin when no more come.
TEST(LiveBeginning, APinchWaitsAQuarterOfASecond) {
  const auto due_with = [](double third_s) {
    return dueIn(framesOf(2.0,
                          [=](double t) {
                            return t < 0.495 ? 1 : t < third_s ? 2 : 3;
                          }),
                 2)
        .value_or(0.0);
  };
  EXPECT_NEAR(due_with(9.0), 0.75, 0.0101);
  EXPECT_NEAR(due_with(0.555), 0.64, 0.0101);
  // What opens and closes has not touched for long.
  EXPECT_FALSE(dueIn(framesOf(2.0,
                              [](double t) {
                                return std::fmod(t, 0.3) < 0.1 ? 1 : 2;
                              }),
                     2));
}

// Every tenth of a second, for a second; a pinch as well.
TEST(LiveBeginning, IsPutOffWhereNoGoodPoseIsFound) {
  for (const int touches : {4, 2}) {
    LiveBeginning beginning;
    std::vector<double> times;
    for (int k = 0; k <= 300; ++k) {
      if (!beginning.isDue(0.01 * k, touches, 2)) continue;
      times.push_back(0.01 * k);
      if (!beginning.putOff(0.01 * k)) break;
    }
    ASSERT_EQ(times.size(), 11u);
    EXPECT_NEAR(times[1], 0.1, 0.0101);
    EXPECT_NEAR(times.back(), 1.0, 0.11);
  }
}

TEST(LiveBeginning, IsNotDueWithLessThanThree) {
  const Frames two = framesOf(2.0, [](double) {
    return LiveBeginning::kTouchesToBegin - 1;
  });
  EXPECT_FALSE(dueIn(two, 1)) << "of one finger";
  EXPECT_FALSE(dueIn(framesOf(2.0, [](double) {
    return LiveBeginning::kTouchesToPinch - 1;
  })));
  // Nor by touches that were there before.
  const auto due = dueIn(framesOf(2.0, [](double t) {
    return t < 0.105 ? 0 : t < 0.155 ? 4 : t < 0.995 ? 1 : 4;
  }));
  ASSERT_TRUE(due);
  EXPECT_NEAR(*due, 1.08, 0.0101);
}

TEST(LiveBeginning, TheFirstFrameTellsOfNothingThatComes) {
  EXPECT_EQ(dueIn({{7.0, 3}}), 7.0);
  EXPECT_EQ(dueIn({{7.0, 2}}, 2), 7.0) << "a pinch";
  EXPECT_FALSE(dueIn({{7.0, 2}}, 1)) << "of one finger";
  EXPECT_EQ(dueIn({{7.0, 0}, {7.5, 3}}), 7.5) << "behind a pause";
  EXPECT_EQ(dueIn({{7.0, 0}, {0.0, 3}}), 0.0) << "time has begun anew";
}

// A search that somebody called off is made in the next frame.
TEST(LiveBeginning, StaysDue) {
  LiveBeginning beginning;
  EXPECT_TRUE(beginning.isDue(1.0, 3, 2));
  EXPECT_TRUE(beginning.isDue(1.01, 5, 2));
  EXPECT_FALSE(beginning.isDue(1.02, 2, 2));
}

}  // namespace
}  // namespace handgraft::retargeting
