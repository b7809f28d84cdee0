#include "core/transfer/patch_transfer.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/contact/patch.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using contact::Patch;
using geometry::positionOf;
using geometry::SurfacePoint;
using geometry::TriangleMesh;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

int nearestVertex(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  int best = 0;
  (mesh.vertices().colwise() - p).colwise().norm().minCoeff(&best);
  return best;
}

/// A patch whose interpolation boundary are the mesh's vertices nearest to `points`.
Patch patchThrough(const TriangleMesh& mesh,
                   const Eigen::Vector3d& root,
                   const Eigen::Vector3d& direction,
                   const std::vector<Eigen::Vector3d>& points) {
  Patch patch;
  patch.name = "thumb";
  patch.root = surfacePointAtVertex(mesh, nearestVertex(mesh, root));
  patch.direction_O = direction;
  for (const Eigen::Vector3d& p : points) {
    patch.interpolation_boundary.push_back(surfacePointAtVertex(mesh, nearestVertex(mesh, p)));
  }
  return patch;
}

PatchPlacement placedAt(const TriangleMesh& skin,
                        const Eigen::Vector3d& root,
                        const Eigen::Vector3d& direction) {
  return {surfacePointAtVertex(skin, nearestVertex(skin, root)), direction};
}

std::vector<Eigen::Vector3d> circle(double radius, int count) {
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < count; ++k) {
    points.emplace_back(radius * std::cos(2 * kPi * k / count),
                        radius * std::sin(2 * kPi * k / count), 0.0);
  }
  return points;
}

/// A plate of 60 x 60 mm as the whole hand.
struct PlateHand {
  TriangleMesh plate = test::makePlate(30, 30, 0.002);
  std::shared_ptr<const hand::HandModel> model = test::makeRigidHand(plate);
  hand::Skin skin = test::makeRigidSkin(*model, plate);
};

TEST(PatchTransfer, MirrorsThePatchAboutTheDirectionBetweenPlanes) {
  const PlateHand hand;
  const TriangleMesh object = test::makePlate(40, 40, 0.002);
  const Patch patch = patchThrough(object, {0, 0, 0}, Eigen::Vector3d::UnitX(),
                                   {{0.01, 0.0, 0}, {0.02, 0.012, 0}, {-0.004, 0.008, 0}});
  const PatchTransfer transfer = transferPatch(
      object, patch, hand.skin, placedAt(hand.plate, {0, 0, 0}, Eigen::Vector3d::UnitY()));

  ASSERT_EQ(transfer.correspondences.size(), 3u);
  EXPECT_TRUE(transfer.lost.empty());
  EXPECT_NEAR(transfer.fidelity.distance_max, 0.0, 1e-9);
  // The direction's coordinate u goes to y on the hand; v, to its left, goes to its right: x.
  const Eigen::Vector3d expected[] = {{0, 0.01, 0}, {0.012, 0.02, 0}, {0.008, -0.004, 0}};
  for (int i = 0; i < 3; ++i) {
    const Correspondence& pair = transfer.correspondences[i];
    EXPECT_LT((pair.p_L - expected[i]).norm(), 1e-9) << pair.p_L.transpose();
    EXPECT_LT((pair.p_O - positionOf(object, patch.interpolation_boundary[i])).norm(), 1e-15);
    EXPECT_LT((pair.n_L - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_LT((transfer.points_S[i] - expected[i]).norm(), 1e-9);
  }
}

TEST(PatchTransfer, KeepsArcLengthFromASphereToAPlane) {
  const PlateHand hand;
  const double radius = 0.03;
  const TriangleMesh sphere = geometry::makeSphere(radius, 5);
  std::vector<Eigen::Vector3d> ring;
  for (const Eigen::Vector3d& p : circle(1.0, 12)) {
    ring.push_back(
        radius * Eigen::Vector3d(std::sin(0.5) * p.x(), std::sin(0.5) * p.y(), std::cos(0.5)));
  }
  const Patch patch = patchThrough(sphere, {0, 0, radius}, Eigen::Vector3d::UnitX(), ring);
  const PatchTransfer transfer = transferPatch(
      sphere, patch, hand.skin, placedAt(hand.plate, {0, 0, 0}, Eigen::Vector3d::UnitX()));

  const Eigen::Vector3d root = positionOf(sphere, patch.root).normalized();
  ASSERT_EQ(transfer.correspondences.size(), 12u);
  for (const Correspondence& pair : transfer.correspondences) {
    const double arc = radius * std::acos(pair.p_O.normalized().dot(root));
    EXPECT_NEAR(pair.p_L.norm(), arc, 0.01 * arc);
  }
}

TEST(PatchTransfer, GrowsTheDiskUntilItHoldsPointsThatAreNearOnlyThroughTheAir) {
  // An open cylinder: points three quarters of the way round are nearer through it than along
  // it.
  const double radius = 0.008;
  const TriangleMesh flat = test::makePlate(50, 20, 0.001);
  Eigen::Matrix3Xd bent = flat.vertices();
  for (int v = 0; v < flat.vertexCount(); ++v) {
    const double angle = flat.vertex(v).x() / radius;
    bent.col(v) << radius * std::sin(angle), flat.vertex(v).y(), radius * std::cos(angle);
  }
  const TriangleMesh cylinder(bent, flat.faces());
  Patch patch = patchThrough(flat, {0, 0, 0}, Eigen::Vector3d::UnitX(),
                             {{0.024, 0, 0}, {-0.024, 0, 0}, {0, 0.009, 0}});
  const PlateHand hand;
  const PatchTransfer transfer = transferPatch(
      cylinder, patch, hand.skin, placedAt(hand.plate, {0, 0, 0}, Eigen::Vector3d::UnitX()));
  ASSERT_EQ(transfer.correspondences.size(), 3u);
  const double chord = 2 * radius * std::sin(0.0005 / radius);  // one of 24 facets
  EXPECT_NEAR(transfer.correspondences[0].p_L.x(), 24 * chord, 1e-9);
  EXPECT_NEAR(transfer.correspondences[1].p_L.x(), -24 * chord, 1e-9);
}

TEST(PatchTransfer, DoesNotDependOnWhereTheObjectIs) {
  const PlateHand hand;
  const TriangleMesh sphere = geometry::makeSphere(0.03, 4);
  std::vector<Eigen::Vector3d> ring;
  for (const Eigen::Vector3d& p : circle(0.012, 9))
    ring.push_back(p + Eigen::Vector3d(0, 0, 0.0275));
  const Patch patch = patchThrough(sphere, {0, 0, 0.03}, {1, 0.2, 0}, ring);
  const PatchPlacement placement = placedAt(hand.plate, {0.002, 0.004, 0}, {0.3, 1, 0});
  const PatchTransfer here = transferPatch(sphere, patch, hand.skin, placement);

  Eigen::Affine3d X(Eigen::Translation3d(0.4, -1, 2));
  X.rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, -1).normalized()));
  Patch moved = patch;
  moved.direction_O = X.linear() * *patch.direction_O;
  const PatchTransfer there =
      transferPatch(transformed(sphere, X), moved, hand.skin, placement);

  ASSERT_EQ(here.correspondences.size(), there.correspondences.size());
  for (std::size_t i = 0; i < here.correspondences.size(); ++i) {
    const Correspondence& a = here.correspondences[i];
    const Correspondence& b = there.correspondences[i];
    EXPECT_LT((a.p_L - b.p_L).norm(), 1e-11);
    EXPECT_LT((X * a.p_O - b.p_O).norm(), 1e-12);
    EXPECT_LT((X.linear() * a.n_O - b.n_O).norm(), 1e-9);
  }
}

TEST(PatchTransfer, ThereAndBackIsWhereItBegan) {
  const TriangleMesh object = geometry::makeSphere(0.03, 5);
  const TriangleMesh other = geometry::makeSphere(0.04, 5);
  const auto object_hand = test::makeRigidHand(object);
  const auto other_hand = test::makeRigidHand(other);
  std::vector<Eigen::Vector3d> ring;
  for (const Eigen::Vector3d& p : circle(0.012, 15)) {
    ring.push_back(Eigen::Vector3d(1.5 * p.x(), p.y(), 0).eval() +
                   Eigen::Vector3d(0, 0, 0.026));
  }
  const Patch patch = patchThrough(object, {0, 0, 0.03}, {1, 0, 0}, ring);
  const PatchPlacement there = placedAt(other, {0.04, 0, 0}, {0, 0, 1});
  const hand::Skin other_skin = test::makeRigidSkin(*other_hand, other);
  const PatchTransfer out = transferPatch(object, patch, other_skin, there);
  ASSERT_EQ(out.points_S.size(), 15u);

  Patch back;
  back.name = "thumb";
  back.root = there.root_S;
  back.direction_O = there.direction_S;
  for (const Eigen::Vector3d& p : out.points_S) {
    back.interpolation_boundary.push_back(other_skin.locator().nearest(p).point);
  }
  const PatchTransfer home = transferPatch(
      other, back, test::makeRigidSkin(*object_hand, object), {patch.root, *patch.direction_O});
  ASSERT_EQ(home.points_S.size(), 15u);
  for (int i = 0; i < 15; ++i) {
    const Eigen::Vector3d p = positionOf(object, patch.interpolation_boundary[i]);
    EXPECT_LT((home.points_S[i] - p).norm(), 1e-6) << i;
  }
}

TEST(PatchTransfer, ReportsPointsBeyondTheEdgeOfTheSkin) {
  const PlateHand hand;
  const TriangleMesh object = test::makePlate(60, 60, 0.002);
  const Patch patch = patchThrough(object, {0, 0, 0}, {1, 0, 0},
                                   {{0.01, 0, 0}, {0.05, 0, 0}, {-0.01, 0.01, 0}});
  const PatchTransfer transfer =
      transferPatch(object, patch, hand.skin, placedAt(hand.plate, {0, 0, 0}, {1, 0, 0}));
  EXPECT_EQ(transfer.correspondences.size(), 2u);
  ASSERT_EQ(transfer.lost.size(), 1u);
  EXPECT_EQ(transfer.lost[0].index, 1);
  EXPECT_THAT(transfer.lost[0].reason, HasSubstr("edge"));
}

TEST(PatchTransfer, SaysWhetherTheBoundaryGoesRoundTheRoot) {
  const PlateHand hand;
  const TriangleMesh object = test::makePlate(40, 40, 0.002);
  const auto is_outside = [&](const Eigen::Vector3d& root) {
    const Patch patch = patchThrough(object, root, Eigen::Vector3d::UnitX(), circle(0.01, 12));
    return transferPatch(object, patch, hand.skin,
                         placedAt(hand.plate, {0, 0, 0}, Eigen::Vector3d::UnitX()))
        .root_is_outside;
  };
  EXPECT_FALSE(is_outside({0, 0, 0}));
  EXPECT_FALSE(is_outside({0.006, 0.004, 0}));
  EXPECT_FALSE(is_outside({0.01, 0, 0})) << "on the boundary";
  EXPECT_TRUE(is_outside({0.02, 0, 0}));
}

TEST(PatchTransfer, ReportsPointsWhereTheSkinHasNoLink) {
  const TriangleMesh skin_mesh = test::makePlate(30, 30, 0.002);
  const auto model = test::makeRigidHand(test::makePlate(10, 10, 0.002));
  const hand::Skin skin = test::makeRigidSkin(*model, skin_mesh);
  const Patch patch = patchThrough(skin_mesh, {0, 0, 0}, {1, 0, 0},
                                   {{0.006, 0, 0}, {0.02, 0, 0}, {0, 0.008, 0}});
  const PatchTransfer transfer =
      transferPatch(skin_mesh, patch, skin, placedAt(skin_mesh, {0, 0, 0}, {1, 0, 0}));
  EXPECT_EQ(transfer.correspondences.size(), 2u);
  ASSERT_EQ(transfer.lost.size(), 1u);
  EXPECT_THAT(transfer.lost[0].reason, HasSubstr("no link within 4.0 mm"));
}

TEST(PatchTransfer, ReportsPointsThatHangTogetherWithNoRoot) {
  const PlateHand hand;
  const TriangleMesh two =
      geometry::merged({test::makePlate(10, 10, 0.002),
                        transformed(test::makePlate(10, 10, 0.002),
                                    Eigen::Affine3d(Eigen::Translation3d(0.1, 0, 0)))});
  const Patch patch =
      patchThrough(two, {0, 0, 0}, {1, 0, 0}, {{0.006, 0, 0}, {0.1, 0, 0}, {0, 0.008, 0}});
  const PatchTransfer transfer =
      transferPatch(two, patch, hand.skin, placedAt(hand.plate, {0, 0, 0}, {1, 0, 0}));
  EXPECT_EQ(transfer.correspondences.size(), 2u);
  ASSERT_EQ(transfer.lost.size(), 1u);
  EXPECT_THAT(transfer.lost[0].reason, HasSubstr("not reached"));
}

TEST(PatchTransfer, RefusesADirectionAlongTheNormal) {
  const PlateHand hand;
  const TriangleMesh object = test::makePlate(10, 10, 0.002);
  Patch patch = patchThrough(object, {0, 0, 0}, {0, 0, 1},
                             {{0.004, 0, 0}, {0.004, 0.004, 0}, {0, 0.004, 0}});
  const PatchPlacement good = placedAt(hand.plate, {0, 0, 0}, {1, 0, 0});
  EXPECT_THROW(transferPatch(object, patch, hand.skin, good), InvalidInput);
  patch.direction_O = Eigen::Vector3d::UnitX();
  PatchPlacement bad = good;
  bad.direction_S = Eigen::Vector3d::UnitZ();
  EXPECT_THROW(transferPatch(object, patch, hand.skin, bad), InvalidInput);
  bad = good;
  bad.root_S.face = hand.plate.faceCount();
  EXPECT_THROW(transferPatch(object, patch, hand.skin, bad), InvalidInput);
  patch.direction_O.reset();
  EXPECT_THROW(transferPatch(object, patch, hand.skin, good), BrokenContract);
}

TEST(PatchPlacement, AtASiteLiesOnTheSkinAndKeepsItsDirection) {
  const PlateHand hand;
  hand::ContactSite site;
  site.name = "thumb";
  site.link = "plate";
  site.p_L = Eigen::Vector3d(0.011, -0.007, 0.001);
  site.n_L = Eigen::Vector3d::UnitZ();
  site.direction_L = Eigen::Vector3d::UnitY();
  const PatchPlacement placement = placementAt(*hand.model, hand.skin, site);
  EXPECT_LT(
      (positionOf(hand.plate, placement.root_S) - Eigen::Vector3d(0.011, -0.007, 0)).norm(),
      1e-12);
  EXPECT_LT((placement.direction_S - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

}  // namespace
}  // namespace handgraft::transfer
