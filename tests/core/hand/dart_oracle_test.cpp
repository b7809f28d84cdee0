// Link poses and Jacobians against DART, which shares no code with ours but urdfdom.
#include <random>
#include <regex>

#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/io/urdf_file.h"

#include "tests/support/dart_hand.h"
#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

class DartOracle : public ::testing::TestWithParam<const char*> {};

TEST_P(DartOracle, AgreesOnLinkPosesAndJacobians) {
  HANDGRAFT_NEEDS_SHARED_DATA(GetParam());
  const std::filesystem::path path = test::sharedData(GetParam());
  // With the joints of a free root as well, which DART knows as any others.
  const HandModel model = io::readUrdfKinematics(path, io::FloatingBase::kKept);
  const dart::dynamics::SkeletonPtr skeleton = test::dartHand(path);
  ASSERT_NE(skeleton, nullptr);
  // DART nails a root called "world" (MANO's) to the world, instead of letting it float.
  const bool is_nailed = model.links()[0].name == "world";
  ASSERT_EQ(static_cast<int>(skeleton->getNumDofs()), model.dofCount() + (is_nailed ? 0 : 6));

  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double worst_pose = 0.0;
  double worst_jacobian = 0.0;
  for (int trial = 0; trial < 100; ++trial) {
    HandPose pose;
    if (!is_nailed) {
      pose.X_WH.linear() = rotationFromVector(
          Eigen::Vector3d(uniform(random), uniform(random), uniform(random)));
      pose.X_WH.translation() << uniform(random), uniform(random), uniform(random);
      auto* root = dynamic_cast<dart::dynamics::FreeJoint*>(skeleton->getRootJoint());
      ASSERT_NE(root, nullptr);
      root->setTransform(pose.X_WH);
    }
    pose.q.resize(model.dofCount());
    for (int i = 0; i < model.dofCount(); ++i) {
      pose.q[i] = uniform(random);
      skeleton->getDof(model.dofJoint(i).name)->setPosition(pose.q[i]);
    }
    const LinkPoses X_WL = forwardKinematics(model, pose);
    for (int link = is_nailed ? 1 : 0; link < model.linkCount(); ++link) {
      const auto* body =
          skeleton->getBodyNode(model.links()[static_cast<std::size_t>(link)].name);
      ASSERT_NE(body, nullptr);
      const Pose& X = X_WL[static_cast<std::size_t>(link)];
      worst_pose = std::max(
          worst_pose, (body->getWorldTransform().matrix() - X.matrix()).cwiseAbs().maxCoeff());

      const Eigen::Vector3d p_L(uniform(random), uniform(random), uniform(random));
      const auto J = pointJacobian(model, X_WL, link, X * p_L);
      Eigen::MatrixXd dart_jacobian = Eigen::MatrixXd::Zero(6, model.dofCount());
      const auto body_jacobian = skeleton->getWorldJacobian(body, p_L);
      for (int i = 0; i < model.dofCount(); ++i)
        dart_jacobian.col(i) = body_jacobian.col(static_cast<Eigen::Index>(
            skeleton->getDof(model.dofJoint(i).name)->getIndexInSkeleton()));
      worst_jacobian = std::max(worst_jacobian, (J - dart_jacobian).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LE(worst_pose, 1e-9);
  EXPECT_LE(worst_jacobian, 1e-9);
}

// Mia is left out: DART 6.12 does not move mimic joints kinematically.
INSTANTIATE_TEST_SUITE_P(
    Hands,
    DartOracle,
    ::testing::Values("hands/allegro_right/allegro_hand_right.urdf",
                      "hands/barrett_bhand/bhand_model.urdf",
                      "hands/human_hand_graspit20/human_hand_graspit20.urdf",
                      "hands/mano_mean/mano_mean_fixed.urdf",
                      "problems/allegro_mjcf.urdf",
                      "problems/human_hand20.urdf"),
    [](const auto& hand) {
      const std::string stem = std::filesystem::path(hand.param).stem();
      return std::regex_replace(stem, std::regex("[^A-Za-z0-9]"), "");
    });

}  // namespace
}  // namespace handgraft::hand
