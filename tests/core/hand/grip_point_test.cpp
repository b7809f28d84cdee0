#include "core/hand/grip_point.h"

#include <gtest/gtest.h>

#include "core/base/pose.h"
#include "core/hand/finger_coordinates.h"

#include "tests/support/small_hand.h"

namespace handgraft::hand {
namespace {

TEST(GripPoint, IsTheMiddleBetweenThumbAndFingers) {
  JointPlaces joints = JointPlaces::Zero();
  joints.col(4) = Eigen::Vector3d(0.0, 0.0, 0.2);
  for (int finger = 0; finger < 4; ++finger)
    joints.col(8 + 4 * finger) = Eigen::Vector3d(0.1 * finger, 0.04, 0.0);
  EXPECT_TRUE(gripPointOf(joints).isApprox(Eigen::Vector3d(0.075, 0.02, 0.1)));
}

/// A hand with thumb, index and middle finger about z.
struct GripOfSmallHand : testing::Test {
  test::SmallHand small = test::makeSmallHand();
  Hand hand{small.model, small.skin, small.sites};
};

TEST_F(GripOfSmallHand, LiesBetweenItsTips) {
  const LinkPoses X_SL =
      forwardKinematics(*hand.model, {Pose::Identity(), hand.skin->qReference()});
  Eigen::Vector3d thumb = Eigen::Vector3d::Zero();
  Eigen::Vector3d fingers = Eigen::Vector3d::Zero();
  for (const NamedDigit& digit : coordinatesOf(hand)->anatomy().digits)
    (digit.name == "thumb" ? thumb : fingers) += digit.segments.back().end_S;
  const auto grip_S = GripPoint(hand).at(X_SL);
  ASSERT_TRUE(grip_S);
  EXPECT_TRUE(grip_S->isApprox(0.5 * (thumb + 0.5 * fingers), 1e-9));
}

TEST_F(GripOfSmallHand, MovesWithTheHand) {
  const GripPoint point(hand);
  HandPose pose;
  pose.q = hand.skin->qReference();
  const auto grip_H = point.at(forwardKinematics(*hand.model, pose));
  pose.X_WH.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  pose.X_WH.linear() = rotationFromVector(Eigen::Vector3d(0.3, -1.0, 0.2));
  const auto grip_W = point.at(forwardKinematics(*hand.model, pose));
  ASSERT_TRUE(grip_H && grip_W);
  EXPECT_TRUE(grip_W->isApprox(pose.X_WH * *grip_H, 1e-9));
}

}  // namespace
}  // namespace handgraft::hand
