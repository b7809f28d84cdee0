#include "core/hand/hand_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/small_hand.h"

namespace handgraft::hand {
namespace {

using Eigen::Vector3d;

Joint slider(const std::string& name, const std::string& child) {
  Joint joint;
  joint.name = name;
  joint.type = JointType::kPrismatic;
  joint.parent_link = "palm";
  joint.child_link = child;
  joint.lower = 0.0;
  joint.upper = 0.05;
  return joint;
}

Link boxLink(const std::string& name) {
  return {name, {{geometry::makeBox({0.02, 0.02, 0.02}), "box"}}, {}};
}

TEST(HandParts, CallEachLinkByItsFinger) {
  const test::SmallHand small = test::makeSmallHand();
  EXPECT_THAT(
      HandParts(*small.model, small.sites).names(),
      testing::ElementsAre("palm", "thumb", "thumb", "index", "index", "middle", "middle"));
}

TEST(HandParts, FollowTheSitesNames) {
  test::SmallHand small = test::makeSmallHand();
  small.sites = {small.sites[1]};
  small.sites[0].name = "trigger";
  EXPECT_THAT(
      HandParts(*small.model, small.sites).names(),
      testing::ElementsAre("palm", "thumb", "thumb", "trigger", "trigger", "middle", "middle"));
}

TEST(HandParts, NumberFingersWhoseNamesAreTaken) {
  test::SmallHand small = test::makeSmallHand();
  small.sites = {small.sites[1]};
  small.sites[0].name = "middle";
  EXPECT_THAT(HandParts(*small.model, small.sites).names(),
              testing::ElementsAre("palm", "thumb", "thumb", "middle", "middle", "f1", "f1"));
}

TEST(HandParts, NumberJawsThatSlideAndLeaveTheCarrierNameless) {
  Joint wrist = slider("wrist", "palm");
  wrist.parent_link = "arm";
  wrist.type = JointType::kRevolute;
  const HandModel model("gripper",
                        {boxLink("arm"), boxLink("palm"), boxLink("left"), boxLink("right")},
                        {wrist, slider("open_left", "left"), slider("open_right", "right")});
  EXPECT_THAT(HandParts(model, {}).names(), testing::ElementsAre("", "palm", "f1", "f2"));
  EXPECT_FALSE(HandParts(model, {}).towardsWrist(2, Vector3d::UnitX()).has_value());
}

/// With sites and without, the fingers of the small hand say the same: their pads look along
/// -x or x, the wrist lies along -z.
class HandPartsOfSmallHand : public testing::TestWithParam<bool> {
 protected:
  test::SmallHand small = test::makeSmallHand();
  HandParts parts{*small.model, GetParam() ? small.sites : std::vector<ContactSite>()};

  Vector3d towardsWrist(int link, const Vector3d& n_L) const {
    const auto d_L = parts.towardsWrist(link, n_L.normalized());
    EXPECT_TRUE(d_L.has_value());
    return d_L.value_or(Vector3d::Zero());
  }
};

TEST_P(HandPartsOfSmallHand, PointBackAlongTheFinger) {
  for (const int link : {1, 2, 3, 4, 5, 6}) {
    const Vector3d n_L = (link < 3 ? 1.0 : -1.0) * Vector3d::UnitX();  // the pads look inwards
    EXPECT_LT((towardsWrist(link, n_L) + Vector3d::UnitZ()).norm(), 1e-9) << link;
    for (const double side : {-1.0, 1.0}) {
      EXPECT_LT((towardsWrist(link, side * Vector3d::UnitY()) + Vector3d::UnitZ()).norm(), 1e-9)
          << link;
    }
    EXPECT_LT((towardsWrist(link, -n_L) + Vector3d::UnitZ()).norm(), 1e-9)
        << "back of " << link;
  }
}

TEST_P(HandPartsOfSmallHand, PointToThePadWhereTheTipTouches) {
  EXPECT_LT((towardsWrist(2, Vector3d::UnitZ()) - Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LT((towardsWrist(4, Vector3d::UnitZ()) + Vector3d::UnitX()).norm(), 1e-9);
  const Vector3d half = towardsWrist(2, {1.0, 0.0, 1.0});
  EXPECT_LT((half - Vector3d(1.0, 0.0, -1.0).normalized()).norm(), 1e-9);
}

TEST_P(HandPartsOfSmallHand, KnowNoDirectionOnAPalmWithoutASite) {
  EXPECT_FALSE(parts.towardsWrist(0, Vector3d::UnitZ()).has_value());
}

INSTANTIATE_TEST_SUITE_P(Sites, HandPartsOfSmallHand, testing::Bool());

}  // namespace
}  // namespace handgraft::hand
