#include "hardware/bridge/follower_joints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// `tip` follows `base`, and `end` follows `side`.
config::HandConfig coupled() {
  config::HandConfig config;
  config.governor.names = {"base", "tip", "side", "end"};
  config.transmission.followers = {{1, 0, 0.5, 0.1}, {3, 2, -1.0, 0.0}};
  return config;
}

TEST(FollowerJoints, AreWhereTheirLeadersPutThem) {
  const std::vector<LedJoint> led = ledJoints(coupled(), {"side", "base"});
  ASSERT_EQ(led.size(), 2u);
  EXPECT_EQ(led[0].name, "tip");
  EXPECT_EQ(led[1].name, "end");
  std::vector<double> joint_rad = {0.3, 0.8};
  appendLed(led, 2, joint_rad);
  EXPECT_THAT(joint_rad, ElementsAre(0.3, 0.8, 0.5 * 0.8 + 0.1, -0.3));
}

TEST(FollowerJoints, ThatAreToldCountAsTold) {
  EXPECT_THAT(ledJoints(coupled(), {"base", "tip", "side", "end"}), IsEmpty());
  EXPECT_THAT(ledJoints(coupled(), {"tip", "end"}), IsEmpty()) << "nobody leads them";
  EXPECT_THAT(ledJoints(config::HandConfig(), {"base"}), IsEmpty());
}

TEST(FollowerJoints, OfAPoseOfAnotherLengthAreLeftToBeRefused) {
  const std::vector<LedJoint> led = ledJoints(coupled(), {"side", "base"});
  std::vector<double> joint_rad = {0.3};
  appendLed(led, 2, joint_rad);
  EXPECT_THAT(joint_rad, ElementsAre(0.3));
}

}  // namespace
}  // namespace handgraft::bridge
