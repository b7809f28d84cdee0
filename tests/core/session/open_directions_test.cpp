#include "core/session/open_directions.h"

#include <gtest/gtest.h>

#include "tests/core/session/ball_grasp.h"

namespace handgraft::session {
namespace {

using geometry::SurfacePoint;
using geometry::TriangleMesh;

const SurfacePoint kSomewhere{7, {0.5, 0.2, 0.3}};

TEST(TangentAt, LiesInTheTangentPlaneNearestToTheDirection) {
  const TriangleMesh ball = geometry::makeSphere(0.03, 2);
  const Eigen::Vector3d n = normalOf(ball, kSomewhere);
  const Eigen::Vector3d d(3, -1, 2);
  const auto tangent = tangentAt(ball, kSomewhere, d);
  ASSERT_TRUE(tangent.has_value());
  EXPECT_NEAR(tangent->norm(), 1.0, 1e-12);
  EXPECT_NEAR(tangent->dot(n), 0.0, 1e-12);
  EXPECT_NEAR(tangent->dot(d.cross(n)), 0.0, 1e-12);
  EXPECT_GT(tangent->dot(d), 0.0);
}

TEST(TangentAt, IsMissingAlongTheNormal) {
  const TriangleMesh ball = geometry::makeSphere(0.03, 2);
  EXPECT_FALSE(tangentAt(ball, kSomewhere, -2.0 * normalOf(ball, kSomewhere)).has_value());
  EXPECT_FALSE(tangentAt(ball, kSomewhere, Eigen::Vector3d::Zero()).has_value());
}

TEST(TangentCarried, KeepsTheAngleOnAPlaneAndTurnsOverAnEdge) {
  const TriangleMesh box = geometry::makeBox({1, 1, 1});
  SurfacePoint on_top;
  SurfacePoint on_side;
  for (int f = 0; f < box.faceCount(); ++f) {
    const SurfacePoint middle{f, Eigen::Vector3d::Constant(1.0 / 3.0)};
    if (box.faceNormals().col(f).z() > 0.9) on_top = middle;
    if (box.faceNormals().col(f).x() > 0.9) on_side = middle;
  }
  ASSERT_TRUE(on_top.valid() && on_side.valid());
  const Eigen::Vector3d carried =
      tangentCarried(box, on_top, on_side, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(carried.dot(normalOf(box, on_side)), 0.0, 1e-12);
  EXPECT_LT(carried.z(), 0.0);
}

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
