#include "core/base/side_note.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(SideNote, TellsThatTheOtherHandTouchedAlsoToWhoMirrors) {
  EXPECT_EQ(otherSideNote("left", "left"), "");
  EXPECT_EQ(otherSideNote("", "left"), "");
  EXPECT_EQ(otherSideNote("right", ""), "");
  EXPECT_THAT(otherSideNote("right", "left"),
              testing::AllOf(
                  testing::HasSubstr("a right hand touched, and this is a left one"),
                  testing::HasSubstr("with --mirror, or without it if this hand is mirrored")));
}

}  // namespace
}  // namespace handgraft
