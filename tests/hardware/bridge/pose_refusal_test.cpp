#include "hardware/bridge/pose_refusal.h"

#include <vector>

#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using safety::SampleVerdict;
using Names = std::vector<std::string>;

std::string said(SampleVerdict verdict, const Names& told, std::size_t numbers) {
  const Names hand{"a", "b", "c"};
  return std::string(describeRefusal(verdict, hand, told, numbers).view());
}

TEST(PoseRefusal, NamesTheFirstJointThatIsMissingAndTheFirstTooMany) {
  EXPECT_EQ(said(SampleVerdict::kWrongNames, {"a", "x", "y"}, 3),
            "wrong joint names: 'b' is missing, 'x' is none of its joints");
  EXPECT_EQ(said(SampleVerdict::kWrongNames, {"a", "b", "b"}, 3),
            "wrong joint names: 'c' is missing, 'b' is there twice");
  EXPECT_EQ(said(SampleVerdict::kWrongLength, {"a", "b"}, 2),
            "wrong number of joints: 2 for the hand's 3, 'c' is missing");
  EXPECT_EQ(said(SampleVerdict::kWrongLength, {"a", "b", "c", "d"}, 4),
            "wrong number of joints: 4 for the hand's 3, 'd' is none of its joints");
  EXPECT_EQ(said(SampleVerdict::kWrongLength, {"a", "b", "c"}, 2),
            "wrong number of joints: 2 for the hand's 3");
}

TEST(PoseRefusal, SaysNothingOfJointsWhereTheyAreNotTheMatter) {
  EXPECT_EQ(said(SampleVerdict::kNotFinite, {"a"}, 1), "not finite");
}

TEST(PoseRefusal, PrintsNamesFromElsewhereBoundedAndPlain) {
  const std::string text =
      said(SampleVerdict::kWrongNames, {"a", "b", "\x1b[31m" + std::string(1000, 'z')}, 3);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_LT(text.size(), 200u);
  EXPECT_NE(text.find("'c' is missing"), std::string::npos);
}

}  // namespace
}  // namespace handgraft::bridge
