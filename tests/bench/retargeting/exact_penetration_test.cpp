// The judge of depths against closed forms: it shares nothing with what solvers charge for.
#include "tests/bench/retargeting/exact_penetration.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include "tests/support/shared_data.h"

namespace handgraft::bench {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.010;

/// The wrap's ball is a polyhedron, and samples are a millimetre or two apart.
constexpr double kTolerance = 3e-4;

hand::Link linkOf(const std::string& name, const geometry::TriangleMesh& mesh) {
  hand::Link link;
  link.name = name;
  if (mesh.faceCount() > 0) link.visuals = {{mesh, name}};
  return link;
}

hand::Joint slider(const std::string& name,
                   const std::string& parent,
                   const std::string& child,
                   const Vector3d& axis) {
  hand::Joint joint;
  joint.name = name;
  joint.type = hand::JointType::kPrismatic;
  joint.parent_link = parent;
  joint.child_link = child;
  joint.axis_J = axis;
  joint.lower = -1.0;
  joint.upper = 1.0;
  return joint;
}

/// Two balls that slide along x and y; the second one's rest is 0.1 m aside.
std::shared_ptr<const hand::HandModel> twoBalls() {
  const geometry::TriangleMesh ball = geometry::makeSphere(kRadius, 4);
  std::vector<hand::Joint> joints{slider("x", "base", "left", Vector3d::UnitX()),
                                  slider("y", "base", "right", Vector3d::UnitX())};
  joints[1].X_PJ.translation().x() = 0.1;
  return std::make_shared<const hand::HandModel>(
      "balls",
      std::vector<hand::Link>{linkOf("base", {}), linkOf("left", ball), linkOf("right", ball)},
      joints);
}

const ExactHand& balls() {
  static const ExactHand ball_hand(twoBalls(), test::scratchDirectory());
  return ball_hand;
}

ExactPenetration measured(const geometry::TriangleMesh& object, double left, double right) {
  const ExactSolid solid(object, ExactPenetration::kObjectSpacing);
  return measureExactly(balls(), solid, {Pose::Identity(), Eigen::Vector2d(left, right)});
}

/// A box whose face x = 0 looks to +x.
geometry::TriangleMesh block(double thickness) {
  return geometry::transformed(geometry::makeBox({thickness, 0.2, 0.2}),
                               Eigen::Affine3d(Eigen::Translation3d(-0.5 * thickness, 0, 0)));
}

TEST(ExactPenetration, OfABallInAHalfSpaceIsItsCap) {
  for (const double depth : {0.0, 0.001, 0.004, 0.010}) {
    SCOPED_TRACE(depth);
    const ExactPenetration found = measured(block(0.1), kRadius - depth, 0.2);
    EXPECT_NEAR(found.hand_in_object_m, depth, kTolerance);
    // The deepest place is at most 0.75 mm from a sample, which as deep as the centre costs all
    // of it.
    EXPECT_NEAR(found.object_in_hand_m, depth, 0.00075);
    const double cap = std::numbers::pi * depth * depth * (kRadius - depth / 3.0);
    // Cells are counted whole: of the layer that the plane cuts, up to half a cell too many.
    const double base = std::numbers::pi * depth * (2.0 * kRadius - depth);
    EXPECT_NEAR(found.volume_m3, cap, 0.5 * ExactPenetration::kCell * base + 0.1 * cap + 1e-8);
    EXPECT_EQ(found.deepest_link, depth > 0.0005 ? 1 : found.deepest_link);
  }
}

TEST(ExactPenetration, OfAFingerThroughAThinWallIsTheFingersNotTheWalls) {
  const ExactPenetration found = measured(block(0.002), -0.001, 0.2);
  EXPECT_NEAR(found.hand_in_object_m, 0.001, kTolerance) << "half the wall";
  EXPECT_NEAR(found.object_in_hand_m, std::sqrt(kRadius * kRadius) - 0.001, kTolerance);
  EXPECT_EQ(found.deepest(), found.object_in_hand_m);
}

TEST(ExactPenetration, OfASheetOfOneLayerCounts) {
  Eigen::Matrix3Xd corners(3, 4);
  corners << 0, 0, 0, 0, -0.1, 0.1, 0.1, -0.1, -0.1, -0.1, 0.1, 0.1;
  Eigen::Matrix3Xi faces(3, 2);
  faces << 0, 0, 1, 2, 2, 3;
  const ExactPenetration found = measured({corners, faces}, 0.003, 0.2);
  EXPECT_EQ(found.hand_in_object_m, 0.0) << "a sheet has no inside";
  EXPECT_EQ(found.volume_m3, 0.0);
  EXPECT_NEAR(found.object_in_hand_m, kRadius - 0.003, kTolerance);
}

TEST(ExactPenetration, OfAHandInItselfIsTheOverlap) {
  // Centres at 0.04 and 0.1 - 0.044: 16 mm apart, so that each lies 4 mm in the other.
  const ExactPenetration found = measured(block(0.1), 0.04, -0.044);
  EXPECT_EQ(found.deepest(), 0.0);
  EXPECT_NEAR(found.self_m, 2.0 * kRadius - 0.016, kTolerance);
  EXPECT_EQ(found.self_links, (std::array<int, 2>{1, 2}));
}

TEST(ExactSolid, MeasuresBothSidesOfTheBodyThatItsMeshStandsOff) {
  const ExactSolid solid(geometry::makeSphere(kRadius, 5), 0.002, 0.001);
  EXPECT_NEAR(solid.depth(Vector3d::Zero()), kRadius - 0.001, 1e-5);
  EXPECT_EQ(solid.depth({0, 0, kRadius - 0.0005}), 0.0);
  EXPECT_NEAR(solid.distance({0, 0, 0.02}), 0.02 - kRadius + 0.001, 1e-5);
  EXPECT_NEAR(solid.distance({0, 0, kRadius - 0.0005}), 0.0005, 1e-5);
  for (const Vector3d& p : solid.cells(0.001))
    EXPECT_LT(p.norm(), kRadius);
  EXPECT_NEAR(static_cast<double>(solid.cells(0.001).size()) * 1e-9,
              4.0 / 3.0 * std::numbers::pi * std::pow(kRadius - 0.001, 3), 2e-7);
}

}  // namespace
}  // namespace handgraft::bench
