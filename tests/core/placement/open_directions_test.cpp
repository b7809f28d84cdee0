#include "core/placement/open_directions.h"

#include <gtest/gtest.h>

#include "core/geometry/tangent.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::placement {
namespace {

using geometry::SurfacePoint;

TEST(DirectionShownBy, IsTheHandsOwnDirectionSeenFromTheObject) {
  const test::BallGrasp grasp;
  const auto anchor = anchorAt(
      *grasp.small.skin,
      transfer::placementAt(*grasp.small.model, *grasp.small.skin, grasp.small.sites[0]));
  ASSERT_TRUE(anchor.has_value());
  EXPECT_LT((anchor->direction_L - grasp.small.sites[0].direction_L).norm(), 1e-9);

  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd::Zero(6)};
  Pose X_WO = Pose::Identity();
  X_WO.linear() = rotationFromVector({0, 0, 0.5});
  const SurfacePoint root = grasp.contacts.patches[0].root;
  const Eigen::Vector3d direction_O =
      directionShownBy(*grasp.small.model, pose, *anchor, *grasp.ball, root, X_WO);
  const Eigen::Vector3d expected =
      *tangentAt(*grasp.ball, root, X_WO.linear().transpose() * -Eigen::Vector3d::UnitZ());
  EXPECT_LT((direction_O - expected).norm(), 1e-9);
}

TEST(SkinDirectionShownBy, IsTheObjectsDirectionSeenFromTheHandUpToATurn) {
  const geometry::TriangleMesh plate = test::makePlate(20, 20, 0.001);
  const auto model = test::makeRigidHand(plate);
  const hand::Skin skin = test::makeRigidSkin(*model, plate);
  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd(0)};
  pose.X_WH.linear() = rotationFromVector({0.4, -0.7, 0.2});
  const SurfacePoint root{0, Eigen::Vector3d::Constant(1.0 / 3.0)};
  const Eigen::Vector3d bone_S = Eigen::Vector3d::UnitX();
  const auto shown = [&](const Eigen::Vector3d& d_H) {
    return skinDirectionShownBy(skin, skin.fromWorld(*model, pose), root, bone_S,
                                pose.X_WH.linear() * d_H, 0.8);
  };
  const auto tangent = [](double turn) {
    return Eigen::Vector3d(std::cos(turn), std::sin(turn), 0.0);
  };
  for (const double turn : {-0.7, 0.0, 0.5})
    EXPECT_LT((shown(tangent(turn)).value() - tangent(turn)).norm(), 1e-9) << turn;
  EXPECT_LT((shown(tangent(1.2)).value() - tangent(0.8)).norm(), 1e-9);
  EXPECT_LT((shown(tangent(-3.0)).value() - tangent(-0.8)).norm(), 1e-9);
  EXPECT_FALSE(shown(Eigen::Vector3d::UnitZ()).has_value());
}

}  // namespace
}  // namespace handgraft::placement
