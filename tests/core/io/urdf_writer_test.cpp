#include "core/io/urdf_writer.h"

#include <fstream>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/hand/joint_numbers.h"
#include "core/hand/kinematics.h"
#include "core/hand/mirror.h"
#include "core/io/urdf_file.h"
#include "core/io/urdf_text.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

hand::HandModel writtenAndRead(const hand::HandModel& model) {
  const auto path = test::scratchDirectory() / "written.urdf";
  std::ofstream(path) << kinematicUrdfText(model, "written by a test");
  return readUrdfKinematics(path);
}

/// The largest difference of a link's pose (entries of rotation; metres) over some random
/// joints.
double differenceOf(const hand::HandModel& a, const hand::HandModel& b) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  double most = 0.0;
  for (int round = 0; round < 20; ++round) {
    Eigen::VectorXd q(a.dofCount());
    for (double& value : q)
      value = angle(random);
    const auto pose_a = hand::forwardKinematics(a, {Pose::Identity(), q});
    const auto pose_b = hand::forwardKinematics(b, {Pose::Identity(), q});
    for (std::size_t i = 0; i < pose_a.size(); ++i)
      most = std::max(most, (pose_a[i].matrix() - pose_b[i].matrix()).cwiseAbs().maxCoeff());
  }
  return most;
}

void expectSameHand(const hand::HandModel& model) {
  const hand::HandModel read = writtenAndRead(model);
  EXPECT_EQ(read.name(), model.name());
  EXPECT_EQ(read.dofNames(), model.dofNames());
  ASSERT_EQ(read.linkCount(), model.linkCount());
  for (int i = 0; i < model.linkCount(); ++i)
    EXPECT_EQ(read.links()[static_cast<std::size_t>(i)].name,
              model.links()[static_cast<std::size_t>(i)].name);
  EXPECT_EQ(read.lower(), model.lower());
  EXPECT_EQ(read.upper(), model.upper());
  EXPECT_EQ(read.mimicCount(), model.mimicCount());
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    for (const hand::JointNumber& number : hand::kJointNumbers)
      EXPECT_EQ(read.dofJoint(dof).*number.value, model.dofJoint(dof).*number.value)
          << number.name;
  }
  EXPECT_LT(differenceOf(model, read), 1e-12);
}

hand::Joint jointAt(const std::string& name,
                    const std::string& parent,
                    hand::JointType type,
                    const Eigen::Matrix3d& R_PJ) {
  hand::Joint joint;
  joint.name = name;
  joint.type = type;
  joint.parent_link = parent;
  joint.child_link = "after " + name;
  joint.X_PJ.translation() = Eigen::Vector3d(0.1, -1.0 / 3.0, 1e-7);
  joint.X_PJ.linear() = R_PJ;
  joint.axis_J = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  return joint;
}

TEST(KinematicUrdf, KeepsJointsOfAllKindsAtAllAngles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  std::vector<hand::Link> links{{"root", {}, {}}};
  std::vector<hand::Joint> joints;
  const double quarter = 0.5 * std::numbers::pi;
  // Pitch about a quarter turn, where roll and yaw turn about the same axis.
  for (const double pitch : {0.3, quarter, -quarter, quarter - 1e-9, quarter + 1e-7, 3.0}) {
    const Eigen::Matrix3d R =
        (AngleAxisd(0.7, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
         AngleAxisd(-2.0, Vector3d::UnitX()))
            .toRotationMatrix();
    const hand::JointType type = joints.size() % 3 == 0   ? hand::JointType::kFixed
                                 : joints.size() % 3 == 1 ? hand::JointType::kRevolute
                                                          : hand::JointType::kPrismatic;
    hand::Joint joint =
        jointAt("j" + std::to_string(joints.size()), links.back().name, type, R);
    if (joints.size() > 2) {
      joint.lower = -0.1 / 3.0;
      joint.upper = 0.2;
      for (const hand::JointNumber& number : hand::kJointNumbers)
        if (number.urdf_element != nullptr) joint.*number.value = 1.7;
    }
    links.push_back({joint.child_link, {}, {}});
    joints.push_back(joint);
  }
  joints[1].velocity_limit = 2.5;
  joints[4].mimic = hand::Mimic{"j1", -1.0 / 7.0, 0.05};
  joints[4].lower = -10.0;
  joints[4].upper = 10.0;
  expectSameHand(hand::HandModel("odd <&> \"hand\"", links, joints));
}

TEST(KinematicUrdf, KeepsTheEffortsThatItIsTold) {
  std::vector<hand::Joint> joints{
      jointAt("a", "root", hand::JointType::kRevolute, Eigen::Matrix3d::Identity()),
      jointAt("b", "after a", hand::JointType::kRevolute, Eigen::Matrix3d::Identity())};
  for (hand::Joint& joint : joints) {
    joint.lower = 0.0;
    joint.upper = 1.0;
  }
  const hand::HandModel model(
      "two", {{"root", {}, {}}, {"after a", {}, {}}, {"after b", {}, {}}}, joints);
  const std::string text = kinematicUrdfText(model, "written by a test", {{"b", 0.85}});
  EXPECT_EQ(effortLimitsOf(text), (std::map<std::string, double>{{"a", 0.0}, {"b", 0.85}}));
  EXPECT_TRUE(
      effortLimitsOf("<robot><joint name=\"a\"><limit effort=\"much\"/></joint>").empty());
}

TEST(KinematicUrdf, DescribesTheMirroredHand) {
  for (const char* name : {"human20", "barrett8"}) {
    const UrdfFile file = readUrdf(test::sourceDirectory() / "server/models/hands" / name /
                                   (std::string(name) + ".urdf"));
    expectSameHand(hand::mirrored(file.model, "left"));
    EXPECT_GT(differenceOf(file.model, writtenAndRead(hand::mirrored(file.model, "left"))),
              0.01);
  }
}

}  // namespace
}  // namespace handgraft::io
