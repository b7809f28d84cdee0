#include "core/base/error.h"

#include <gtest/gtest.h>

#include "core/base/progress.h"

namespace handgraft {
namespace {

TEST(Quoted, KeepsOneLineWhateverAFileSays) {
  EXPECT_EQ(quoted("a\nb\tc\x7f"), "'a?b?c?'");
  EXPECT_EQ(quoted(""), "''");
}

TEST(Quoted, CutsLongTexts) {
  const std::string line = quoted(std::string(100000, 'x'));
  EXPECT_EQ(line.size(), 200u + 2u + 3u);
}

TEST(Quoted, CutsBetweenCharacters) {
  const std::string half(199, 'x');
  EXPECT_EQ(quoted(half + "öö"), "'" + half + "ö...'");
}

TEST(Require, ThrowsWithThePlaceAndTheCondition) {
  try {
    HANDGRAFT_REQUIRE(1 + 1 == 3);
    FAIL() << "must throw";
  } catch (const BrokenContract& error) {
    EXPECT_NE(std::string(error.what()).find("1 + 1 == 3"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("error_test.cpp"), std::string::npos);
  }
}

TEST(RejectInput, FormatsTheMessage) {
  try {
    rejectInput("joint '{}': {} rad is above its limit {} rad", "thumb_mcp", 2.1, 1.57);
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "joint 'thumb_mcp': 2.1 rad is above its limit 1.57 rad");
  }
}

TEST(Progress, CheckpointThrowsOnceCancelled) {
  Progress progress;
  EXPECT_NO_THROW(progress.checkpoint());
  progress.cancel();
  EXPECT_THROW(progress.checkpoint(), Cancelled);
}

TEST(Progress, ReportsToItsListener) {
  std::string seen;
  const Progress progress([&](std::string_view stage, double) {
    seen = stage;
  });
  progress.report("wrapping the skin", 0.5);
  EXPECT_EQ(seen, "wrapping the skin");
}

}  // namespace
}  // namespace handgraft
