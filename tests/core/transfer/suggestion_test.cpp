#include "core/transfer/suggestion.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kRadius = 0.008;

/// A round patch on a plate, to be laid onto a hand that is a plate of 60 x 60 mm.
struct RoundPatchOnAPlate {
  TriangleMesh plate = test::makePlate(30, 30, 0.002);
  std::shared_ptr<const hand::HandModel> model = test::makeRigidHand(plate);
  hand::Skin skin = test::makeRigidSkin(*model, plate);
  contact::Patch patch;

  RoundPatchOnAPlate() {
    patch.name = "thumb";
    patch.root = skin.locator().nearest({0, 0, 0}).point;
    patch.direction_O = Eigen::Vector3d::UnitX();
    for (int i = 0; i < 24; ++i) {
      const double phi = 2.0 * std::numbers::pi * i / 24;
      patch.interpolation_boundary.push_back(
          skin.locator().nearest({kRadius * std::cos(phi), kRadius * std::sin(phi), 0}).point);
    }
  }

  [[nodiscard]] PatchPlacement at(double x, double y) const {
    return {skin.locator().nearest({x, y, 0}).point, Eigen::Vector3d::UnitX()};
  }

  [[nodiscard]] std::vector<Suggestion> suggest(const PatchPlacement& present,
                                                const SuggestOptions& options) const {
    return suggestPlacements(plate, patch, skin, present, options, {}, Progress());
  }
};

TEST(SuggestPlacements, BringsAPatchBackThatHangsOverTheEdge) {
  const RoundPatchOnAPlate world;
  const PatchPlacement present = world.at(0.027, 0.003);  // 5 mm over the edge at x = 30 mm
  const PatchTransfer now = transferPatch(world.plate, world.patch, world.skin, present);
  ASSERT_FALSE(now.lost.empty());

  const std::vector<Suggestion> suggestions = world.suggest(present, {0.010, 5});
  ASSERT_FALSE(suggestions.empty());
  EXPECT_LE(suggestions.size(), 5u);
  const Suggestion& best = suggestions.front();
  EXPECT_TRUE(best.transfer.lost.empty());
  // The outline's outermost of 24 points has to come back by 5 mm; the search ends at a 32nd
  // of its reach and does not go back without need.
  EXPECT_GT(best.moved_m, 0.0049);
  EXPECT_LT(best.moved_m, 0.0062);
  const Eigen::Vector3d root = positionOf(world.plate, best.placement.root_S);
  EXPECT_NEAR((root - positionOf(world.plate, present.root_S)).norm(), best.moved_m, 1e-9);
  EXPECT_LE(root.x() + kRadius, 0.030 + 1e-9);
}

TEST(SuggestPlacements, DeliversWhatItPromises) {
  const RoundPatchOnAPlate world;
  const PatchPlacement present = world.at(0.026, -0.0266);  // over a corner
  const std::size_t lost =
      transferPatch(world.plate, world.patch, world.skin, present).lost.size();
  std::size_t before = 0;
  for (const Suggestion& suggestion : world.suggest(present, {0.008, 10})) {
    // The two edits that make it come true.
    const PatchPlacement placement =
        turned(world.plate, movedTo(world.plate, present, suggestion.placement.root_S),
               suggestion.turned_rad);
    EXPECT_EQ(placement.direction_S, suggestion.placement.direction_S);
    const PatchTransfer laid = transferPatch(world.plate, world.patch, world.skin, placement);
    EXPECT_EQ(laid.lost.size(), suggestion.transfer.lost.size());
    EXPECT_LT(laid.lost.size(), lost);
    EXPECT_GE(laid.lost.size(), before);  // best first
    EXPECT_LE(suggestion.moved_m, 0.008 * (1 + 1e-9));
    before = laid.lost.size();
  }
}

TEST(SuggestPlacements, HasNothingToSayWhereNothingIsLostOrNothingHelps) {
  const RoundPatchOnAPlate world;
  EXPECT_TRUE(world.suggest(world.at(0.0, 0.0), {0.010, 5}).empty());
  // A patch as large as three plates loses most of its outline wherever it goes.
  RoundPatchOnAPlate large;
  const TriangleMesh wide = test::makePlate(100, 100, 0.002);
  contact::Patch patch = large.patch;
  const geometry::SurfaceLocator locator(wide);
  patch.root = locator.nearest({0, 0, 0}).point;
  patch.interpolation_boundary.clear();
  for (int i = 0; i < 24; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / 24;
    patch.interpolation_boundary.push_back(
        locator.nearest({0.09 * std::cos(phi), 0.09 * std::sin(phi), 0}).point);
  }
  EXPECT_TRUE(
      suggestPlacements(wide, patch, large.skin, large.at(0, 0), {0.010, 5}, {}, Progress())
          .empty());
}

TEST(SuggestPlacements, TurnsALongPatchThatFitsOneWayOnly) {
  // A bar of 50 mm on a strip of 60 x 16 mm, laid slantwise.
  const TriangleMesh strip = test::makePlate(30, 8, 0.002);
  const auto model = test::makeRigidHand(strip);
  const hand::Skin skin = test::makeRigidSkin(*model, strip);
  const TriangleMesh plate = test::makePlate(40, 40, 0.002);
  const geometry::SurfaceLocator locator(plate);
  contact::Patch patch;
  patch.name = "palm";
  patch.root = locator.nearest({0, 0, 0}).point;
  patch.direction_O = Eigen::Vector3d::UnitX();
  for (int i = 0; i < 24; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / 24;
    patch.interpolation_boundary.push_back(
        locator.nearest({0.025 * std::cos(phi), 0.004 * std::sin(phi), 0}).point);
  }
  const double slant = 0.5;
  const PatchPlacement present = {skin.locator().nearest({0, 0, 0}).point,
                                  {std::cos(slant), std::sin(slant), 0}};
  const auto suggestions =
      suggestPlacements(plate, patch, skin, present, {0.002, 3}, {}, Progress());
  ASSERT_FALSE(suggestions.empty());
  EXPECT_TRUE(suggestions.front().transfer.lost.empty());
  // The tips leave the strip until sin(turn) 25 mm < 8 mm.
  EXPECT_LT(suggestions.front().turned_rad, std::asin(8.0 / 25.0) - slant + 0.06);
}

TEST(SuggestPlacements, StopsOnWishAndRefusesNumbersOutOfRange) {
  const RoundPatchOnAPlate world;
  const PatchPlacement present = world.at(0.027, 0.003);
  Progress stopped;
  stopped.cancel();
  EXPECT_THROW(
      suggestPlacements(world.plate, world.patch, world.skin, present, {}, {}, stopped),
      Cancelled);
  for (const SuggestOptions& options :
       {SuggestOptions{0.0, 5}, {0.2, 5}, {std::nan(""), 5}, {0.01, 0}, {0.01, 101}}) {
    EXPECT_THAT(
        [&] {
          (void)world.suggest(present, options);
        },
        ThrowsMessage<InvalidInput>(HasSubstr("permitted are")));
  }
}

}  // namespace
}  // namespace handgraft::transfer
