#include "core/io/trajectory_writer.h"

#include <cstring>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

#include "core/formats/npz_file.h"
#include "core/geometry/triangle_mesh.h"
#include "core/io/hand_trajectory_file.h"
#include "core/io/trajectory_rows.h"

#include "tests/support/shared_data.h"
#include "tests/support/small_hand.h"

namespace handgraft::io {
namespace {

using nlohmann::json;

/// A hand that turns with its object by 1 rad about z in 1 s, one joint moving, on no contact.
HandTrajectory turning(int frames) {
  static const test::SmallHand small = test::makeSmallHand();
  HandTrajectory trajectory;
  trajectory.hand = "small";
  trajectory.object = "ball";
  trajectory.motion = "turn";
  trajectory.model = small.model;
  trajectory.object_O =
      std::make_shared<const geometry::TriangleMesh>(geometry::makeSphere(0.03, 2));
  for (int k = 0; k < frames; ++k) {
    const double share = frames == 1 ? 0.0 : static_cast<double>(k) / (frames - 1);
    TrajectoryFrame frame;
    frame.time_s = 2.0 + share;
    frame.X_WO.linear() = rotationFromVector({0.0, 0.0, share});
    frame.X_WO.translation() << 0.1 * share, 0.0, 0.3;
    frame.pose_W.X_WH = frame.X_WO * Eigen::Translation3d(0.0, 0.0, -0.1);
    frame.pose_W.q = small.model->restPose();
    frame.pose_W.q[0] += 0.25 * share;
    frame.depths = {0.0012, 0.0004};
    trajectory.frames.push_back(frame);
  }
  return trajectory;
}

TEST(TrajectoryRows, HaveTheVelocitiesOfWhatTheyShow) {
  const TrajectoryRows rows = rowsOf(turning(101));
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  ASSERT_EQ(rows.qpos.rows(), 14 + joints);
  ASSERT_EQ(rows.qvel.rows(), 12 + joints);
  EXPECT_EQ(rows.time_s.front(), 0.0);
  for (const Eigen::Index k : {Eigen::Index{0}, Eigen::Index{50}, Eigen::Index{100}}) {
    EXPECT_NEAR(rows.qvel(6, k), 0.25, 1e-9);               // the first joint
    EXPECT_NEAR(rows.qvel(12 + joints - 6, k), 0.1, 1e-9);  // the object, along x
    EXPECT_NEAR(rows.qvel(12 + joints - 1, k), 1.0, 1e-9);  // and about z
    EXPECT_NEAR(rows.qpos.col(k).segment(3, 4).norm(), 1.0, 1e-12);
  }
}

TEST(TrajectoryRows, OfOneFrameStandStill) {
  EXPECT_EQ(rowsOf(turning(1)).qvel.norm(), 0.0);
}

TEST(TrajectoryWriter, TextsAreReadBack) {
  const HandTrajectory trajectory = turning(11);
  const TrajectoryRows rows = rowsOf(trajectory);
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  for (const std::string& text : {trajectoryJson(trajectory), trajectoryCsv(trajectory)}) {
    const std::filesystem::path path = test::scratchDirectory() / "what_a_hand_did";
    std::ofstream(path, std::ios::binary) << text;
    const HandTrajectoryFile file = readHandTrajectory(path);
    EXPECT_EQ(file.joints, rows.joint_names);
    ASSERT_EQ(file.frames.size(), 11u);
    for (const Eigen::Index k : {Eigen::Index{0}, Eigen::Index{5}, Eigen::Index{10}}) {
      const HandTrajectoryFile::Frame& frame = file.frames[static_cast<std::size_t>(k)];
      EXPECT_NEAR(frame.time_s, rows.time_s[static_cast<std::size_t>(k)], 1e-9);
      EXPECT_LT((frame.q - rows.qpos.col(k).segment(7, joints)).norm(), 1e-8);
      const TrajectoryFrame& was = trajectory.frames[static_cast<std::size_t>(k)];
      EXPECT_TRUE(frame.X_WO.isApprox(was.X_WO, 1e-8));
      EXPECT_TRUE(frame.X_WH.isApprox(was.pose_W.X_WH, 1e-8));
    }
  }
}

TEST(TrajectoryWriter, TextsSayTheSame) {
  const HandTrajectory trajectory = turning(11);
  const TrajectoryRows rows = rowsOf(trajectory);
  const json document = json::parse(trajectoryJson(trajectory));
  EXPECT_EQ(document.at("format"), "handgraft-trajectory/1");
  ASSERT_EQ(document.at("frames").size(), 11u);
  EXPECT_NEAR(document.at("frames").at(10).at("joints").at(0), rows.qpos(7, 10), 1e-12);

  const std::string csv = trajectoryCsv(trajectory);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 12);

  const YAML::Node ros = YAML::Load(rosTrajectoryYaml(trajectory));
  ASSERT_EQ(ros["points"].size(), 11u);
  EXPECT_EQ(ros["joint_names"].size(), static_cast<std::size_t>(rows.independent));
  EXPECT_NEAR(ros["points"][10]["positions"][0].as<double>(), rows.qpos(7, 10), 1e-9);
  EXPECT_NEAR(ros["points"][5]["velocities"][0].as<double>(), 0.25, 1e-6);
  EXPECT_EQ(ros["points"][5]["time_from_start"]["nanosec"].as<int>(), 500'000'000);

  const std::string mjcf = trajectoryMjcf(trajectory);
  EXPECT_THAT(mjcf, testing::HasSubstr("<key name=\"frame_10\" time=\"1\" qpos=\""));
}

// On its way out, and in again.
TEST(TrajectoryWriter, APatchThatIsThereTwiceCountsOnceInRows) {
  HandTrajectory trajectory = turning(2);
  trajectory.patch_names = {"thumb", "index"};
  trajectory.frames[1].patches = {{1, 0.25, 3.0, 10.0, true, {9.0, 9.0, 9.0}},
                                  {1, 0.75, 1.0, 20.0, true, {1.0, 2.0, 3.0}}};
  const auto arrays = formats::readNpz(trajectoryNpz(trajectory));
  EXPECT_THAT(arrays.at("contact").values, testing::ElementsAre(0.0, 0.0, 0.0, 0.75));
  EXPECT_THAT(arrays.at("contact_pos").values,
              testing::ElementsAre(0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3));
  const json document = json::parse(trajectoryJson(trajectory));
  EXPECT_EQ(document.at("frames").at(1).at("patches").size(), 2u);
}

TEST(TrajectoryWriter, GlbMovesEveryPartOverTheWholeTime) {
  const HandTrajectory trajectory = turning(11);
  const std::string glb = trajectoryGlb(trajectory);
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, 4);
  const json document = json::parse(glb.substr(20, size));
  const json& animation = document.at("animations").at(0);
  std::size_t parts = 0;
  for (const json& node : document.at("nodes"))
    parts += node.contains("mesh") ? 1 : 0;
  EXPECT_EQ(animation.at("channels").size(), 2 * parts);
  const json& times = document.at("accessors")
                          .at(animation.at("samplers").at(0).at("input").get<std::size_t>());
  EXPECT_EQ(times.at("count"), 11);
  EXPECT_EQ(times.at("max").at(0), 1.0);
}

}  // namespace
}  // namespace handgraft::io
