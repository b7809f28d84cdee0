#include "core/transfer/staged_transfer.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/tangent.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMapMethod;
using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// An egg-shaped patch on a ball of 30 mm, to be laid onto a ball of 40 mm.
struct TwoBalls {
  TriangleMesh object = geometry::makeSphere(0.03, 4);
  TriangleMesh skin_mesh = geometry::makeSphere(0.04, 4);
  std::shared_ptr<const hand::HandModel> model = test::makeRigidHand(skin_mesh);
  hand::Skin skin = test::makeRigidSkin(*model, skin_mesh);
  Surfaces surfaces = borrowedSurfaces(object, skin);
  contact::Patch patch;
  PatchPlacement placement;

  TwoBalls() {
    patch.name = "thumb";
    patch.root = {301, {0.2, 0.5, 0.3}};
    patch.direction_O = geometry::anyTangentAt(object, patch.root);
    const geometry::LogMap map = computeLogMap(object, patch.root, *patch.direction_O, 0.02);
    const geometry::LogMapInverse inverse(object, map);
    for (int i = 0; i < 25; ++i) {
      const double phi = 2.0 * std::numbers::pi * i / 25;
      const double r = 0.009 + 0.003 * std::cos(phi);
      patch.interpolation_boundary.push_back(
          inverse.at(r * Eigen::Vector2d(std::cos(phi), std::sin(phi))).point);
    }
    placement.root_S = {77, {0.1, 0.1, 0.8}};
    placement.direction_S = geometry::anyTangentAt(skin_mesh, placement.root_S);
  }
};

void expectSame(const PatchTransfer& a, const PatchTransfer& b) {
  ASSERT_EQ(a.correspondences.size(), b.correspondences.size());
  for (std::size_t i = 0; i < a.correspondences.size(); ++i) {
    EXPECT_EQ(a.correspondences[i].p_L, b.correspondences[i].p_L);
    EXPECT_EQ(a.correspondences[i].n_L, b.correspondences[i].n_L);
    EXPECT_EQ(a.correspondences[i].p_O, b.correspondences[i].p_O);
    EXPECT_EQ(a.points_S[i], b.points_S[i]);
  }
  EXPECT_EQ(a.lost.size(), b.lost.size());
  EXPECT_EQ(a.fidelity.distance_mean, b.fidelity.distance_mean);
  EXPECT_EQ(a.fidelity.angle_max_rad, b.fidelity.angle_max_rad);
  EXPECT_EQ(a.fidelity.area_ratio, b.fidelity.area_ratio);
}

TEST(StagedTransfer, GivesTheOneShotsBytesWhateverWasLaidBefore) {
  TwoBalls balls;
  StagedTransfer staged;
  const TransferOptions options;
  for (int step = 0; step < 6; ++step) {
    switch (step) {
      case 1:
        balls.placement = turned(balls.skin_mesh, balls.placement, 0.7);
        break;
      case 2:
        balls.patch.direction_O =
            tangentTurned(balls.object, balls.patch.root, *balls.patch.direction_O, -2.0);
        break;
      case 3:
        balls.placement = movedTo(balls.skin_mesh, balls.placement, {90, {0.3, 0.4, 0.3}});
        break;
      case 4:
        balls.patch.root = {302, {0.2, 0.5, 0.3}};
        break;
      case 5:
        balls.placement = movedTo(balls.skin_mesh, balls.placement, {77, {0.1, 0.1, 0.8}});
        break;
      default:
        break;
    }
    expectSame(staged.lay(balls.surfaces, balls.patch, balls.placement, options),
               transferPatch(balls.object, balls.patch, balls.skin, balls.placement, options));
  }
}

TEST(StagedTransfer, MakesOnlyTheChartsAnewThatAnEditReaches) {
  TwoBalls balls;
  StagedTransfer staged;
  const TransferOptions options;
  staged.lay(balls.surfaces, balls.patch, balls.placement, options);
  const auto patch_chart = staged.patchChart();
  const auto skin_chart = staged.skinChart();

  // Directions, weights and names: nothing.
  balls.placement = turned(balls.skin_mesh, balls.placement, 1.1);
  balls.patch.direction_O =
      tangentTurned(balls.object, balls.patch.root, *balls.patch.direction_O, 0.4);
  balls.patch.weight = 3.0;
  staged.lay(balls.surfaces, balls.patch, balls.placement, options);
  EXPECT_EQ(staged.patchChart(), patch_chart);
  EXPECT_EQ(staged.skinChart(), skin_chart);

  // The root on the hand: the skin's chart alone.
  balls.placement = movedTo(balls.skin_mesh, balls.placement, {80, {0.3, 0.4, 0.3}});
  staged.lay(balls.surfaces, balls.patch, balls.placement, options);
  EXPECT_EQ(staged.patchChart(), patch_chart);
  EXPECT_NE(staged.skinChart(), skin_chart);

  // Another method, or rings: the patch's chart, too.
  staged.lay(balls.surfaces, balls.patch, balls.placement, {LogMapMethod::kExact, 0});
  EXPECT_NE(staged.patchChart(), patch_chart);
}

TEST(StagedTransfer, TurningADirectionIsLayingTheTurnedPatchAnew) {
  // Against log maps made with the turned directions themselves.
  TwoBalls balls;
  for (const LogMapMethod method : {LogMapMethod::kFast, LogMapMethod::kExact}) {
    const Eigen::Vector3d direction_O =
        tangentTurned(balls.object, balls.patch.root, *balls.patch.direction_O, 0.9);
    const PatchPlacement placement = turned(balls.skin_mesh, balls.placement, -0.6);
    balls.patch.direction_O = direction_O;
    const PatchTransfer laid =
        transferPatch(balls.object, balls.patch, balls.skin, placement, {method, 0});
    const geometry::LogMap map_O =
        computeLogMap(balls.object, balls.patch.root, direction_O, 0.02, method);
    const geometry::LogMap map_S =
        computeLogMap(balls.skin_mesh, placement.root_S, placement.direction_S, 0.02, method);
    const geometry::LogMapInverse inverse(balls.skin_mesh, map_S);
    ASSERT_EQ(laid.points_S.size(), 25u);
    for (int i = 0; i < 25; ++i) {
      const Eigen::Vector2d uv =
          logCoordinates(balls.object, map_O, balls.patch.interpolation_boundary[i]);
      const Eigen::Vector3d expected =
          positionOf(balls.skin_mesh, inverse.at(Eigen::Vector2d(uv.x(), -uv.y())).point);
      EXPECT_LT((laid.points_S[i] - expected).norm(), 1e-12);
    }
  }
}

TEST(StagedTransfer, InteriorRingsLieAtTheirShareOfTheWay) {
  // On planes: shrunken copies of the outline about the root.
  const TriangleMesh plate = test::makePlate(30, 30, 0.002);
  const auto model = test::makeRigidHand(plate);
  const hand::Skin skin = test::makeRigidSkin(*model, plate);
  contact::Patch patch;
  patch.name = "thumb";
  patch.root = skin.locator().nearest({0.001, 0.002, 0}).point;
  patch.direction_O = Eigen::Vector3d::UnitX();
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.01, 0, 0), {0, 0.012, 0}, {-0.01, -0.01, 0}})
    patch.interpolation_boundary.push_back(skin.locator().nearest(p).point);
  const PatchTransfer laid = transferPatch(
      plate, patch, skin, {patch.root, Eigen::Vector3d::UnitX()}, {LogMapMethod::kFast, 2});
  ASSERT_EQ(laid.correspondences.size(), 9u);
  EXPECT_EQ(laid.boundary_count, 3);
  const Eigen::Vector3d root = positionOf(plate, patch.root);
  for (int ring = 1; ring <= 2; ++ring) {
    for (int i = 0; i < 3; ++i) {
      const Correspondence& outer = laid.correspondences[i];
      const Correspondence& inner = laid.correspondences[3 * ring + i];
      EXPECT_LT((inner.p_O - root - ring / 3.0 * (outer.p_O - root)).norm(), 1e-12);
      EXPECT_LT((inner.p_L - root - ring / 3.0 * (outer.p_L - root)).norm(), 1e-12);
    }
  }
}

TEST(StagedTransfer, SaysWhichMethodItUsed) {
  const TwoBalls balls;
  for (const LogMapMethod method : {LogMapMethod::kFast, LogMapMethod::kExact,
                                    LogMapMethod::kSmooth, LogMapMethod::kHeat}) {
    const PatchTransfer laid =
        transferPatch(balls.object, balls.patch, balls.skin, balls.placement, {method, 0});
    EXPECT_EQ(laid.method_O, method);
    EXPECT_EQ(laid.method_S, method);
    EXPECT_EQ(laid.correspondences.size(), 25u);
  }
  const PatchTransfer chosen = transferPatch(balls.object, balls.patch, balls.skin,
                                             balls.placement, {LogMapMethod::kAuto, 0});
  EXPECT_NE(chosen.method_S, LogMapMethod::kAuto);
}

TEST(StagedTransfer, DraftsAreLaidByTheQuickMethodAndMeasureNothing) {
  TwoBalls balls;
  StagedTransfer staged;
  const PatchTransfer full = staged.lay(balls.surfaces, balls.patch, balls.placement, {});
  const PatchTransfer draft =
      staged.lay(balls.surfaces, balls.patch, balls.placement, {}, true);
  EXPECT_TRUE(draft.is_draft);
  EXPECT_EQ(draft.method_S, LogMapMethod::kFast);
  EXPECT_EQ(draft.method_O, full.method_O);
  EXPECT_EQ(draft.fidelity.area_ratio, Fidelity().area_ratio);
  ASSERT_EQ(draft.points_S.size(), full.points_S.size());
  for (std::size_t i = 0; i < draft.points_S.size(); ++i)
    EXPECT_LT((draft.points_S[i] - full.points_S[i]).norm(), 0.0005);

  // Nothing of a draft stays, and a method that somebody asked for is kept to.
  expectSame(staged.lay(balls.surfaces, balls.patch, balls.placement, {}), full);
  TransferOptions exact;
  exact.method = LogMapMethod::kExact;
  EXPECT_EQ(staged.lay(balls.surfaces, balls.patch, balls.placement, exact, true).method_S,
            LogMapMethod::kExact);
}

/// The placement with its root at another place of the same ball.
PatchPlacement rootedAt(const TwoBalls& balls, int face) {
  return movedTo(balls.skin_mesh, balls.placement, {face, {0.6, 0.3, 0.1}});
}

TEST(StagedTransfer, DraftsShareChartsAndLieNearlyWhereOthersDo) {
  TwoBalls balls;
  balls.surfaces.drafts_S = std::make_shared<const DraftCharts>(balls.skin);
  StagedTransfer staged;
  StagedTransfer exact;
  double worst = 0.0;
  for (int face = 0; face < balls.skin_mesh.faceCount(); face += 97) {
    const PatchPlacement placement = rootedAt(balls, face);
    const PatchTransfer draft = staged.lay(balls.surfaces, balls.patch, placement, {}, true);
    const PatchTransfer full = exact.lay(balls.surfaces, balls.patch, placement, {});
    ASSERT_EQ(draft.points_S.size(), full.points_S.size());
    for (std::size_t i = 0; i < draft.points_S.size(); ++i)
      worst = std::max(worst, (draft.points_S[i] - full.points_S[i]).norm());
  }
  // On a ball of radius R, two ways of s to a place at r, d apart at their ends, disagree by
  // some d r s / (2 R^2).
  EXPECT_LT(worst, 0.0008);
  EXPECT_GT(worst, 1e-6) << "nothing was shared";
}

TEST(StagedTransfer, DraftsAreTheSameWhoeverAskedFirst) {
  TwoBalls one;
  TwoBalls other;
  one.surfaces.drafts_S = std::make_shared<const DraftCharts>(one.skin);
  other.surfaces.drafts_S = std::make_shared<const DraftCharts>(other.skin);
  const std::vector<int> faces = {77, 78, 300, 79, 301, 76};
  std::vector<PatchTransfer> forth;
  for (const int face : faces)
    forth.push_back(
        StagedTransfer().lay(one.surfaces, one.patch, rootedAt(one, face), {}, true));
  for (std::size_t i = faces.size(); i-- > 0;)
    expectSame(
        StagedTransfer().lay(other.surfaces, other.patch, rootedAt(other, faces[i]), {}, true),
        forth[i]);
}

TEST(StagedTransfer, RefusesRingsOutOfRange) {
  const TwoBalls balls;
  for (const int rings : {-1, 17}) {
    EXPECT_THAT(
        [&] {
          transferPatch(balls.object, balls.patch, balls.skin, balls.placement,
                        {LogMapMethod::kFast, rings});
        },
        ThrowsMessage<InvalidInput>(HasSubstr("permitted are 0 to 16")));
  }
}

}  // namespace
}  // namespace handgraft::transfer
