#include "client/link/pose_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::filesystem::path file(const std::string& text) {
  static int count = 0;
  const auto path = test::scratchDirectory() / ("pose" + std::to_string(++count) + ".json");
  std::ofstream(path) << text;
  return path;
}

std::string objectionTo(const std::string& text) {
  try {
    readPose(file(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(PoseFile, NeedsJointsAlone) {
  const PoseFile pose = readPose(file(R"({"joints": {"bend": 0.5, "spread": -1}})"));
  EXPECT_THAT(pose.joints, ElementsAre("bend", "spread"));
  EXPECT_THAT(pose.joint_rad, ElementsAre(0.5, -1.0));
  EXPECT_FALSE(pose.X_WH.has_value());
  EXPECT_FALSE(pose.X_WO.has_value());
  EXPECT_TRUE(readPose(file(R"({"joints": {}})")).joints.empty());
}

TEST(PoseFile, ReadsPosesWithQuaternionsOfAnyLengthNearOne) {
  const PoseFile pose =
      readPose(file(R"({"joints": {}, "X_WH": {"p_m": [1, 2, 3], "q_wxyz": [0, 1, 0, 0]},
               "X_WO": {"p_m": [0, 0, 0.1], "q_wxyz": [1, 0, 0, 0]}})"));
  ASSERT_TRUE(pose.X_WH && pose.X_WO);
  EXPECT_THAT(pose.X_WH->p_m(), ElementsAre(1.0, 2.0, 3.0));
  EXPECT_NEAR(std::abs(pose.X_WH->q_wxyz()[1]), 1.0, 1e-12);
  EXPECT_EQ(pose.X_WO->p_m()[2], 0.1);
}

TEST(PoseFile, ReadsAResultOfGrasp) {
  const PoseFile pose = readPose(file(R"({"format": "handgraft-grasp/1", "hand": "claw",
      "joints": {"bend": 1}, "X_WH": {"p_m": [0, 0, 0], "q_wxyz": [1, 0, 0, 0]},
      "links_X_WL": {"tip": {"p_m": [0, 0, 0.2], "q_wxyz": [1, 0, 0, 0]}},
      "objective": null})"));
  EXPECT_EQ(pose.links_X_WL.at("tip").p_m()[2], 0.2);
}

TEST(PoseFile, NamesTheFieldThatIsWrong) {
  EXPECT_THAT(objectionTo("{"), HasSubstr("no JSON"));
  EXPECT_THAT(objectionTo("[]"), HasSubstr("one object"));
  EXPECT_THAT(objectionTo("{}"), HasSubstr("'joints'"));
  EXPECT_THAT(objectionTo(R"({"joints": [1]})"), HasSubstr("'joints'"));
  EXPECT_THAT(objectionTo(R"({"joints": {"bend": "1"}})"), HasSubstr("'bend'"));
  EXPECT_THAT(objectionTo(R"({"joints": {"bend": 1e999}})"), HasSubstr("pose"));
  EXPECT_THAT(objectionTo(R"({"joints": {}, "X_HW": {}})"), HasSubstr("'X_HW'"));
  EXPECT_THAT(objectionTo(R"({"joints": {}, "X_WH": {"p_m": [1, 2]}})"), HasSubstr("'p_m'"));
  EXPECT_THAT(
      objectionTo(R"({"joints": {}, "X_WO": {"p_m": [0, 0, 0], "q_wxyz": [0, 0, 0, 0]}})"),
      HasSubstr("X_WO"));
  EXPECT_THAT(objectionTo(R"({"format": "handgraft-problem/1", "joints": {}})"),
              HasSubstr("handgraft-grasp/1"));
}

}  // namespace
}  // namespace handgraft::client
