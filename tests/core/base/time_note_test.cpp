#include "core/base/time_note.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft {
namespace {

using testing::HasSubstr;

/// Times of frames so far apart, from 1970 or so.
std::vector<double> times(int count, double interval) {
  std::vector<double> all;
  for (int k = 0; k < count; ++k)
    all.push_back(1000.0 + k * interval);
  return all;
}

TEST(TimeNote, TellsTimesInMilliseconds) {
  EXPECT_THAT(timeUnitNote(times(30, 1e3 / 30.0)), HasSubstr("milliseconds"));
  EXPECT_THAT(timeUnitNote(times(30, 8.0)), HasSubstr("1000 times too slowly"));
  EXPECT_THAT(timeUnitNote(times(30, 1e6 / 60.0)), HasSubstr("microseconds"));
  EXPECT_THAT(timeUnitNote(times(30, 1e9 / 60.0)), HasSubstr("nanoseconds"));
}

TEST(TimeNote, LeavesSecondsAlone) {
  EXPECT_EQ(timeUnitNote({}), "");
  EXPECT_EQ(timeUnitNote(times(30, 1.0 / 120.0)), "");
  EXPECT_EQ(timeUnitNote(times(30, 1.0)), "");
  EXPECT_EQ(timeUnitNote(times(3, 10.0)), "") << "keys that somebody set";
  std::vector<double> with_a_gap = times(30, 0.1);
  with_a_gap.push_back(2000.0);
  EXPECT_EQ(timeUnitNote(with_a_gap), "");
}

TEST(TimeNote, TellsGaps) {
  EXPECT_EQ(timeGapNote(times(30, 1.0)), "");
  std::vector<double> lost = {0.0, 0.1, 0.2, 0.3, 0.4, 1.4, 1.5};
  EXPECT_EQ(timeGapNote(lost), "1.00 s without frames at 0.40 s");
  lost.push_back(2.1);
  EXPECT_EQ(timeGapNote(lost), "1.00 s without frames at 0.40 s, 2 such gaps of 1.60 s in all");
  EXPECT_EQ(timeGapNote({0.0, 0.01, 0.02, 0.03, 0.11, 0.12}), "") << "less than a tenth";
  EXPECT_EQ(timeGapNote({0.0, 1.0, 7.0}), "") << "keys that somebody set";
}

}  // namespace
}  // namespace handgraft
