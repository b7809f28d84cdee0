// Balls in tubes and between walls, and a round fingertip in holes of both sides of its size.

#include "core/quality/clearance.h"

#include <gtest/gtest.h>

#include "tests/support/small_hand.h"

namespace handgraft::quality {
namespace {

using Eigen::Vector3d;

geometry::SurfaceLocator tube(double radius) {
  return geometry::SurfaceLocator(geometry::makeCylinder(radius, 0.2, 256));
}

TEST(TangentBall, FillsATube) {
  const Ball ball =
      tangentBall(tube(0.012), {0.012, 0, 0.01}, -Vector3d::UnitX(), 0.05, 0.0001);
  EXPECT_NEAR(ball.radius, 0.012, 1e-4);
  EXPECT_NEAR((ball.center - Vector3d(0, 0, 0.01)).norm(), 0.0, 1e-4);
}

TEST(TangentBall, MayEnterTheFarWallByTheLift) {
  const geometry::SurfaceLocator box(geometry::makeBox({0.03, 0.3, 0.3}));
  for (const double lift : {0.0005, 0.002}) {
    const Ball ball = tangentBall(box, {0.015, 0, 0}, -Vector3d::UnitX(), 0.05, lift);
    EXPECT_NEAR(ball.radius, 0.015 + 0.5 * lift, 1e-5);
  }
}

TEST(TangentBall, StopsAtTheMostWhereNothingIsInTheWay) {
  const geometry::SurfaceLocator box(geometry::makeBox({0.03, 0.03, 0.03}));
  const Ball ball = tangentBall(box, {0.015, 0, 0}, Vector3d::UnitX(), 0.04, 0.0005);
  EXPECT_NEAR(ball.radius, 0.0405, 1e-9);
}

TEST(TangentBall, IsNotShrunkByBumpsOfTheLiftsHeight) {
  Eigen::Matrix3Xd vertices = geometry::makeSphere(0.03, 4).vertices();
  const Eigen::Matrix3Xi faces = geometry::makeSphere(0.03, 4).faces();
  for (Eigen::Index v = 0; v < vertices.cols(); v += 3)
    vertices.col(v) *= 1.0 - 0.0003 / 0.03;
  const geometry::SurfaceLocator bumpy(geometry::TriangleMesh(vertices, faces));
  const Vector3d at = vertices.col(4);
  EXPECT_GT(tangentBall(bumpy, at, -at.normalized(), 0.05, 0.0005).radius, 0.027);
}

/// The thumb's tip of the small hand, a ball of 10 mm.
struct Fingertip {
  test::SmallHand hand = test::makeSmallHand();
  ContactBody body =
      bodyBehind(*hand.skin, transfer::placementAt(*hand.model, *hand.skin, hand.sites.at(0)));

  /// In a tube along z, at its wall, the finger along it.
  [[nodiscard]] double lackIn(double tube_radius, bool knows_direction = true) const {
    ContactPlace place{{tube_radius, 0, 0}, -Vector3d::UnitX(), std::nullopt};
    if (knows_direction) place.direction_O = Vector3d::UnitZ();
    return missingClearance(tube(tube_radius), body, place);
  }
};

TEST(ContactBody, IsTheBallThatTheFingertipIs) {
  const Fingertip tip;
  ASSERT_FALSE(tip.body.empty());
  EXPECT_NEAR(tip.body[0].radius, 0.010, 3e-4);
  // In front of the contact, z into the hand.
  EXPECT_NEAR((tip.body[0].center - Vector3d(0, 0, 0.010)).norm(), 0.0, 4e-4);
}

TEST(LackOfRoom, IsNoneInAHoleThatIsWideEnough) {
  const Fingertip tip;
  EXPECT_EQ(tip.lackIn(0.0107), 0.0);
  EXPECT_EQ(tip.lackIn(0.0107, false), 0.0);
}

TEST(LackOfRoom, IsWhatTheFingerEntersTheFarWall) {
  // 20 mm in 18: 2 mm, of which a tilt by 10 degrees along the tube saves 0.15.
  const Fingertip tip;
  EXPECT_NEAR(tip.lackIn(0.009), 0.00185, 4e-4);
  EXPECT_NEAR(tip.lackIn(0.008), 0.00385, 4e-4);
}

TEST(LackOfRoom, IsNoneForAnEmptyBody) {
  EXPECT_EQ(
      missingClearance(tube(0.005), {}, {{0.005, 0, 0}, -Vector3d::UnitX(), std::nullopt}),
      0.0);
}

TEST(LackOfRoom, PlacesOutsideAreOpenAndInHolesAreNot) {
  const geometry::SurfaceLocator hole = tube(0.012);
  EXPECT_TRUE(isOpen(hole, {{0.012, 0, 0}, Vector3d::UnitX(), std::nullopt}));
  EXPECT_FALSE(isOpen(hole, {{0.012, 0, 0}, -Vector3d::UnitX(), std::nullopt}));
}

}  // namespace
}  // namespace handgraft::quality
