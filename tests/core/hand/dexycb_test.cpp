// Joint positions of measured human grasps, reproduced from their joint values: the kinematics
// of a hand that brings its own free root, against whoever fitted it.
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/hand/floating_base.h"
#include "core/hand/kinematics.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

/// The value of each of the model's joints, out of a list in another order.
Eigen::VectorXd valuesFor(const HandModel& model,
                          const std::vector<std::string>& names,
                          const std::vector<double>& values) {
  Eigen::VectorXd q(model.dofCount());
  for (int i = 0; i < q.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), model.dofJoint(i).name);
    EXPECT_NE(found, names.end()) << model.dofJoint(i).name;
    q[i] = values.at(static_cast<std::size_t>(found - names.begin()));
  }
  return q;
}

TEST(DexYcb, JointPositionsComeOutOfTheJointValues) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb/dexycb_grasps.json");
  const io::UrdfFile file =
      io::readUrdf(test::sharedData("hands/mano_mean/mano_mean_fixed.urdf"));
  ASSERT_TRUE(file.floating_base.has_value());
  EXPECT_EQ(file.floating_base->dofCount(), 6);
  EXPECT_EQ(file.model.dofCount(), 45);

  // Wrist, then index, middle, ring, little and thumb, each from base to tip; the URDF has no
  // tips.
  std::vector<int> links = {0};
  for (const char* digit : {"FF", "MF", "RF", "LF", "TH"}) {
    for (const char* number : {"J2_z", "J1_z", "J0_z"}) {
      const std::string name = std::string(digit) + number;
      for (const Joint& joint : file.model.joints())
        if (joint.name == name) links.push_back(file.model.linkIndex(joint.child_link));
    }
    links.push_back(-1);
  }
  ASSERT_EQ(links.size(), 21U);

  std::ifstream stream(test::sharedData("contacts/dexycb/dexycb_grasps.json"));
  const nlohmann::json data = nlohmann::json::parse(stream);
  const auto names = data.at("qpos_joint_names").get<std::vector<std::string>>();
  double worst_m = 0.0;
  int grasps = 0;
  for (const auto& object : data.at("grasps")) {
    for (const auto& grasp : object) {
      const auto values = grasp.at("qpos").get<std::vector<double>>();
      const Pose X_WH =
          carriedPose(*file.floating_base, valuesFor(*file.floating_base, names, values));
      const LinkPoses X_WL =
          forwardKinematics(file.model, {X_WH, valuesFor(file.model, names, values)});
      const auto joints = grasp.at("joints21").get<std::vector<std::vector<double>>>();
      for (std::size_t i = 0; i < links.size(); ++i) {
        if (links[i] < 0) continue;
        const Eigen::Vector3d p_W(joints[i][0], joints[i][1], joints[i][2]);
        worst_m = std::max(
            worst_m, (X_WL[static_cast<std::size_t>(links[i])].translation() - p_W).norm());
      }
      ++grasps;
    }
  }
  RecordProperty("worst_mm", std::to_string(worst_m * 1e3));
  EXPECT_GT(grasps, 400);
  EXPECT_LE(worst_m, 1e-4);
}

}  // namespace
}  // namespace handgraft::hand
