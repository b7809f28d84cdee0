#include "core/session/open_directions.h"

#include <gtest/gtest.h>

#include "core/geometry/tangent.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::session {
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

}  // namespace
}  // namespace handgraft::session
