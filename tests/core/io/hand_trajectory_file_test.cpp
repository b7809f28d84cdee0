// What a hand did, read back: JSON and CSV alike, and every fault named.
#include "core/io/hand_trajectory_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

json poseAt(double x) {
  return {{"p_m", {x, 0.0, 0.3}}, {"q_wxyz", {1.0, 0.0, 0.0, 0.0}}};
}

json twoFrames() {
  json root = {{"format", "handgraft-trajectory/1"},
               {"hand", "clamp"},
               {"object", "ball"},
               {"joint_names", {"left", "right"}},
               {"frames", json::array()}};
  for (const double share : {0.0, 1.0})
    root["frames"].push_back({{"time_s", share},
                              {"X_WH", poseAt(share)},
                              {"X_WO", poseAt(-share)},
                              {"joints", {0.1 * share, 0.2}},
                              {"max_depth_m", 0.0},
                              {"patches", json::array()}});
  return root;
}

constexpr const char* kHeading =
    "time_s,left,\"the \"\"right\"\", "
    "too\",X_WH.x,X_WH.y,X_WH.z,X_WH.qw,X_WH.qx,X_WH.qy,X_WH.qz,"
    "max_depth_m\r\n";
constexpr const char* kRows =
    "0,0,0.2,0,0,0.3,1,0,0,0,0\r\n1,0.1,0.2,1,0,0.3,1,0,0,0,0.001\r\n";

HandTrajectoryFile read(const std::string& text) {
  const std::filesystem::path path = test::scratchDirectory() / "trajectory.txt";
  std::ofstream(path, std::ios::binary) << text;
  return readHandTrajectory(path);
}

std::string complaintAbout(const std::string& text) {
  try {
    static_cast<void>(read(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(HandTrajectoryFile, SaysWhereJointsHandAndObjectWere) {
  const HandTrajectoryFile file = read(twoFrames().dump());
  EXPECT_EQ(file.object, "ball");
  EXPECT_THAT(file.joints, ElementsAre("left", "right"));
  EXPECT_TRUE(file.tells_root);
  ASSERT_EQ(file.frames.size(), 2u);
  EXPECT_EQ(file.frames[1].time_s, 1.0);
  EXPECT_EQ(file.frames[1].q, Eigen::Vector2d(0.1, 0.2));
  EXPECT_EQ(file.frames[1].X_WH.translation(), Eigen::Vector3d(1.0, 0.0, 0.3));
  EXPECT_EQ(file.frames[1].X_WO.translation(), Eigen::Vector3d(-1.0, 0.0, 0.3));
}

TEST(HandTrajectoryFile, NeedsNoMoreThanTimeAndJoints) {
  json root = twoFrames();
  root.erase("hand");
  root.erase("object");
  for (json& frame : root["frames"])
    for (const char* name : {"X_WH", "X_WO", "max_depth_m", "patches"})
      frame.erase(name);
  const HandTrajectoryFile file = read(root.dump());
  EXPECT_EQ(file.object, "");
  EXPECT_FALSE(file.tells_root);
  EXPECT_TRUE(file.frames[1].X_WO.isApprox(Pose::Identity(), 0.0));
}

TEST(HandTrajectoryFile, IsATableAsWell) {
  const HandTrajectoryFile file = read(std::string(kHeading) + kRows);
  EXPECT_THAT(file.joints, ElementsAre("left", "the \"right\", too"));
  EXPECT_TRUE(file.tells_root);
  ASSERT_EQ(file.frames.size(), 2u);
  EXPECT_EQ(file.frames[1].q, Eigen::Vector2d(0.1, 0.2));
  EXPECT_EQ(file.frames[1].X_WH.translation(), Eigen::Vector3d(1.0, 0.0, 0.3));
  EXPECT_TRUE(file.frames[1].X_WO.isApprox(Pose::Identity(), 0.0));
}

TEST(HandTrajectoryFile, NamesWhatIsWrongInJson) {
  const auto with = [](auto change) {
    json root = twoFrames();
    change(root);
    return complaintAbout(root.dump());
  };
  EXPECT_THAT(with([](json& root) {
                root["format"] = "handgraft-trajectory/2";
              }),
              HasSubstr("field 'format' must be 'handgraft-trajectory/1'"));
  EXPECT_THAT(with([](json& root) {
                root.erase("joint_names");
              }),
              HasSubstr("field 'joint_names' is missing"));
  EXPECT_THAT(with([](json& root) {
                root["joint_names"] = {"left", "left"};
              }),
              HasSubstr("joint 'left' is named twice"));
  EXPECT_THAT(with([](json& root) {
                root["joint_names"] = json::array();
              }),
              HasSubstr("no joint is named"));
  EXPECT_THAT(with([](json& root) {
                root["frames"] = json::array();
              }),
              HasSubstr("field 'frames' is no list of frames"));
  EXPECT_THAT(with([](json& root) {
                root["frames"][1]["joints"] = {0.1};
              }),
              HasSubstr("frame 1: field 'joints' must be a list of 2 numbers"));
  EXPECT_THAT(with([](json& root) {
                root["frames"][1]["joints"][0] = "wide";
              }),
              HasSubstr("frame 1: field 'joints' is '\"wide\"'; it must be a finite number"));
  EXPECT_THAT(with([](json& root) {
                root["frames"][1]["time_s"] = 0.0;
              }),
              HasSubstr("frame 1: its time 0 s does not lie behind the one before it, 0 s"));
  EXPECT_THAT(with([](json& root) {
                root["frames"][1].erase("X_WH");
              }),
              HasSubstr("frame 1: field 'X_WH' is missing"));
  EXPECT_THAT(with([](json& root) {
                root["frames"][0]["X_WO"]["q_wxyz"] = {2, 0, 0, 0};
              }),
              HasSubstr("frame 0: X_WO"));
  EXPECT_THAT(complaintAbout("{ \"format\": "), HasSubstr("trajectory.txt"));
}

TEST(HandTrajectoryFile, NamesWhatIsWrongInATable) {
  EXPECT_THAT(complaintAbout("time,left\n0,0\n"),
              HasSubstr("line 1: column 'time_s' is missing"));
  EXPECT_THAT(complaintAbout("time_s,left,X_WO.x\n0,0,0\n"),
              HasSubstr("line 1: column 'X_WO.y' is missing"));
  EXPECT_THAT(complaintAbout("time_s\n0\n"), HasSubstr("line 1: no joint is named"));
  EXPECT_THAT(complaintAbout("time_s,left\n0,0,0\n"),
              HasSubstr("line 2: has 3 cells; the heading has 2"));
  EXPECT_THAT(complaintAbout("time_s,left\n0,nan\n"),
              HasSubstr("line 2: 'nan' is no finite number"));
  EXPECT_THAT(complaintAbout("time_s,left\n0,0.1rad\n"),
              HasSubstr("line 2: '0.1rad' is no finite number"));
  EXPECT_THAT(complaintAbout("time_s,left\n1,0\n1,0\n"),
              HasSubstr("line 3: its time 1 s does not lie behind the one before it, 1 s"));
  EXPECT_THAT(complaintAbout("time_s,left\n"), HasSubstr("has no frames"));
}

}  // namespace
}  // namespace handgraft::io
