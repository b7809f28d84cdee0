#include "hardware/bridge/hand_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(HandPlan, KeepsTheOrderAndTheLimitsOfTheDescription) {
  const HandPlan plan =
      planHand(handOf("two", {joint("b", -0.5, 1.5), joint("a", -kInfinity, kInfinity)}), {});
  EXPECT_EQ(plan.hand, "two");
  EXPECT_THAT(plan.names, testing::ElementsAre("b", "a"));
  EXPECT_EQ(plan.limits[0].lower, -0.5);
  EXPECT_EQ(plan.limits[0].upper, 1.5);
  EXPECT_EQ(plan.limits[1].upper, kInfinity);
}

TEST(HandPlan, TakesTheSlowerOfModelAndBound) {
  MotionBounds bounds;
  bounds.revolute_velocity = 2;
  const HandPlan plan = planHand(
      handOf("h", {joint("slow", 0, 1, 0.7), joint("fast", 0, 1, 9), joint("mute", 0, 1, 0)}),
      bounds);
  EXPECT_EQ(plan.limits[0].velocity, 0.7);
  EXPECT_EQ(plan.limits[1].velocity, 2);
  EXPECT_EQ(plan.limits[2].velocity, 2);
}

TEST(HandPlan, BoundsPrismaticJointsInMetres) {
  v1::JointInfo slide = joint("slide", 0, 0.05);
  slide.kind(v1::JOINT_PRISMATIC);
  const MotionBounds bounds;
  const HandPlan plan = planHand(handOf("gripper", {slide}), bounds);
  EXPECT_EQ(plan.limits[0].velocity, bounds.prismatic_velocity);
  EXPECT_EQ(plan.limits[0].acceleration, bounds.prismatic_acceleration);
  EXPECT_EQ(plan.limits[0].jerk, bounds.prismatic_jerk);
}

TEST(HandPlan, AMotorThatIsNotThereDrawsAJointThatSlides) {
  v1::JointInfo slide = joint("slide", 0, 0.05);
  slide.kind(v1::JOINT_PRISMATIC);
  v1::HandDescription gripper = handOf("gripper", {joint("turn", 0, 1), slide});
  gripper.rest_positions({0.5, 0.02});
  const HandPlan plan = planHand(gripper, {});
  EXPECT_THAT(restOfMotors(plan), testing::ElementsAre(0.5, testing::DoubleEq(2.0)));
  const config::HandConfig config = simulatedConfig(plan, 0.01);
  const std::unique_ptr<tendon::MotorMap> map = config::makeMotorMap(config);
  std::vector<double> motors(2), residual(2), measured(2);
  const std::vector<double> pose{0.5, 0.03};
  map->command(pose, motors, residual);
  EXPECT_NEAR(motors[1], 3.0, 1e-12) << "a pinion of a centimetre";
  map->measure(motors, measured);
  EXPECT_NEAR(measured[1], 0.03, 1e-15);
  EXPECT_EQ(config.motors[1].range_rad.upper, 5.0);
  EXPECT_NEAR(config.motors[1].velocity_rad_s, 100 * config.governor.limits[1].velocity, 1e-12);
}

TEST(HandPlan, RestsInsideTheLimits) {
  v1::HandDescription hand =
      handOf("h", {joint("told", 0, 1), joint("wild", 0.2, 1), joint("untold", 0.3, 1)});
  hand.rest_positions({0.5, kNaN});
  EXPECT_THAT(planHand(hand, {}).rest, testing::ElementsAre(0.5, 0.2, 0.3));
}

TEST(HandPlan, RefusesDescriptionsThatNoHandCanHave) {
  const auto refuses = [](const v1::HandDescription& hand, const std::string& words) {
    EXPECT_THAT(
        [&] {
          planHand(hand, {});
        },
        ThrowsMessage<InvalidInput>(HasSubstr(words)));
  };
  refuses(handOf("h", {}), "0 joints");
  refuses(handOf("h", std::vector<v1::JointInfo>(513, joint("a", 0, 1))), "513 joints");
  refuses(handOf("h", {joint("a", 0, 1), joint("a", 0, 1)}), "joint name 'a'");
  refuses(handOf("h", {joint("", 0, 1)}), "joint name ''");
  refuses(handOf("h", {joint("a", 1, 0)}), "[1, 0]");
  refuses(handOf("h", {joint("a", kNaN, 1)}), "joint 'a'");
  refuses(handOf("h", {joint("a", 0, 1, -1)}), "velocity limit -1");
  refuses(handOf("h", {joint("a", 0, 1, kNaN)}), "velocity limit nan");
}

TEST(HandPlan, DifferencesOfConfigAndModelAreTold) {
  const v1::HandDescription model = handOf("h", {joint("a", -0.5, 1.5), joint("b", 0, 1)});
  config::HandConfig config;
  config.governor.names = {"b", "a"};
  config.governor.limits = {{.lower = 0.1, .upper = 1}, {.lower = -0.5, .upper = 1.5}};
  EXPECT_EQ(differencesOf(model, config), "") << "in any order; less than the model is fine";
  config.governor.limits[0].upper = 1.2;
  EXPECT_THAT(differencesOf(model, config),
              HasSubstr("joint 'b' may go from 0.1 to 1.2 rad, its model from 0 to 1"));
  config.governor.names[1] = "c";
  EXPECT_THAT(differencesOf(model, config),
              HasSubstr("the model's joint 'a' is not in the config"));
  EXPECT_THAT(differencesOf(model, config),
              HasSubstr("the config's joint 'c' is not in the model"));
}

TEST(HandPlan, AJointThatSlidesInTheModelAndTurnsInTheConfigIsTold) {
  v1::JointInfo slide = joint("jaw", 0, 0.04);
  slide.kind(v1::JOINT_PRISMATIC);
  const v1::HandDescription model = handOf("gripper", {slide});
  config::HandConfig config;
  config.governor.names = {"jaw"};
  config.governor.limits = {{.lower = 0, .upper = 0.04}};
  EXPECT_EQ(differencesOf(model, config),
            "config and model differ: joint 'jaw' turns in the config and slides in its model");
  EXPECT_EQ(kindsThatDiffer(model, config),
            "joint 'jaw' turns in the config and slides in its model");
  config.governor.limits[0].slides = true;
  config.governor.limits[0].travel = 0.012;
  EXPECT_EQ(differencesOf(model, config), "");
  EXPECT_EQ(kindsThatDiffer(model, config), "");
  config.governor.limits[0].upper = 0.0405;
  EXPECT_THAT(differencesOf(model, config),
              HasSubstr("joint 'jaw' may go from 0 to 0.0405 m, its model from 0 to 0.04"));
}

TEST(HandPlan, AFollowerThatSlidesInTheModelAndTurnsInTheConfigIsTold) {
  v1::HandDescription model = handOf("gripper", {joint("jaw", 0, 1)});
  v1::MimicInfo follower;
  follower.joint("other jaw");
  follower.kind(v1::JOINT_PRISMATIC);
  follower.source("jaw");
  follower.multiplier(0.02);
  model.mimics({follower});
  config::HandConfig config;
  config.governor.names = {"jaw", "other jaw"};
  config.governor.limits = {{.lower = 0, .upper = 1}, {.lower = 0, .upper = 0.02}};
  EXPECT_EQ(kindsThatDiffer(model, config),
            "joint 'other jaw' turns in the config and slides in its model");
  config.governor.limits[1].slides = true;
  EXPECT_EQ(kindsThatDiffer(model, config), "");
}

TEST(HandPlan, AFollowerThatFollowsOtherwiseThanInTheModelIsTold) {
  v1::HandDescription model = handOf("h", {joint("a", 0, 1.5)});
  const auto mimic = [](const char* of, const char* source, double multiplier, double offset) {
    v1::MimicInfo info;
    info.joint(of);
    info.source(source);
    info.multiplier(multiplier);
    info.offset(offset);
    return info;
  };
  model.mimics({mimic("b", "a", 1.0, 0.0), mimic("c", "b", 0.5, 0.2)});
  config::HandConfig config;
  config.governor.names = {"a", "b", "c"};
  config.governor.limits.resize(3, {.lower = 0, .upper = 1.5});
  config.transmission.followers = {{1, 0, 1.0, 0.0}, {2, 0, 0.5, 0.2}};
  EXPECT_EQ(differencesOf(model, config), "") << "a chain is followed to its leader";
  config.transmission.followers[0].ratio = 57.3;
  EXPECT_EQ(
      differencesOf(model, config),
      "config and model differ: joint 'b' follows 'a' with ratio 57.3 and offset 0 rad, in "
      "its model 'a' with ratio 1 and offset 0 rad");
  config.transmission.followers = {{1, 0, 1.0, 0.0}, {2, 0, 0.5, 0.0}};
  EXPECT_THAT(
      differencesOf(model, config),
      HasSubstr("joint 'c' follows 'a' with ratio 0.5 and offset 0 rad, in its model 'a' "
                "with ratio 0.5 and offset 0.2 rad"));
}

}  // namespace
}  // namespace handgraft::bridge
