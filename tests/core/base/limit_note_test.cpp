#include "core/base/limit_note.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(LimitNote, TellsAnglesInDegrees) {
  EXPECT_EQ(limitNote("thumb", false, {-0.4, 1.2}, {-0.4, 1.6}), "");
  EXPECT_THAT(
      limitNote("thumb", false, {-0.4, 1.7}, {-0.4, 1.6}),
      HasSubstr("limits -0.4 to 1.7 rad of joint 'thumb' go beyond the hand's own, -0.4 "
                "to 1.6"));
  EXPECT_THAT(limitNote("thumb", false, {30.0, 60.0}, {-0.4, 1.6}),
              AllOf(HasSubstr("30 to 60 rad"), HasSubstr("'thumb'"),
                    HasSubstr("radians, not degrees")));
}

TEST(LimitNote, TellsTravelsInMillimetres) {
  EXPECT_EQ(limitNote("jaw", true, {0.0, 0.04}, {0.0, 0.05}), "");
  EXPECT_THAT(limitNote("jaw", true, {0.0, 20.0}, {0.0, 0.05}),
              AllOf(HasSubstr("0 to 20 m"), HasSubstr("'jaw'"), HasSubstr("beyond 1 m")));
}

TEST(LimitNote, LeavesAloneWhatTheHandHas) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  EXPECT_EQ(limitNote("wheel", false, {-kNone, kNone}, {-kNone, kNone}), "");
  EXPECT_EQ(limitNote("rail", true, {0.0, 1.8}, {0.0, 2.0}), "");
}

}  // namespace
}  // namespace handgraft
