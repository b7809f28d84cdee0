// The example configs in motion: armed when asked, and what the governor decides is what the
// devices are told.

#include "hardware/bridge/motion.h"

#include <random>

#include <fmt/format.h>

#include "hardware/bridge/motion_words.h"

#include "tests/hardware/bridge/every_hand_in_motion.h"
#include "tests/hardware/config/config_texts.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using test::EveryHandInMotion;
using test::exampleReady;
using test::HandInMotion;
using test::largestDifference;

TEST_P(EveryHandInMotion, StandsStillWithoutPowerUntilItIsArmed) {
  const std::vector<double> before = hand.angles();
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  hand.offer(0.9);
  hand.turnFor(2);
  EXPECT_EQ(state(), GovernorState::kIdle);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_EQ(hand.angles(), before);
}

TEST_P(EveryHandInMotion, WhatIsSentIsTheGovernorsOutputWithinOneUnit) {
  if (!traits().has_own_loop)
    GTEST_SKIP() << "it is sent torques: EveryHandInAStorm compares where they lead to";
  const config::HandConfig config = hand.motion().config();
  const std::unique_ptr<tendon::MotorMap> map = config::makeMotorMap(config);
  ASSERT_TRUE(hand.start(0.6)) << told();
  hand.turnFor(20);  // what the hand was off at first has faded
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  std::vector<double> motors(config.motors.size());
  std::vector<double> residual(config.jointCount());
  bool has_moved = false;
  for (int k = 0; k < 400; ++k) {
    if (k % 40 == 0) hand.offer(share(random));
    const std::vector<double> before = hand.state().command;
    hand.turn();
    ASSERT_EQ(state(), GovernorState::kArmed) << told();
    has_moved = has_moved || hand.state().command != before;
    map->command(hand.state().command, motors, residual);
    for (std::size_t i = 0; i < motors.size(); ++i) {
      ASSERT_NEAR(hand.rig().goal(i), motors[i], hand.rig().unit(i)) << "motor " << i;
      EXPECT_GE(hand.rig().goal(i), config.motors[i].range_rad.lower - 1e-6);
      EXPECT_LE(hand.rig().goal(i), config.motors[i].range_rad.upper + 1e-6);
    }
    EXPECT_LT(largestDifference(hand.state().residual, residual), 1e-9);
  }
  EXPECT_TRUE(has_moved);
}

TEST_P(EveryHandInMotion, SaysWhichJointKeepsItFromBeingArmed) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  const std::vector<std::string>& names = hand.motion().config().governor.names;
  StreamPose pose;
  pose.stream = pose.sequence = 1;
  pose.arrived = hand.now();
  pose.names = names;
  pose.names.back() = "tumb";
  pose.joint_rad.resize(names.size());
  hand.motion().offer(pose);
  const std::string why =
      "wrong joint names: '" + names.back() + "' is missing, 'tumb' is none of its joints";
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "pose refused: " + why);
  hand.motion().request(Request::kArm);
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "ARM refused: no fresh pose: " + why);
  EXPECT_FALSE(hand.rig().isPowered());
  hand.offer(0.4);
  hand.motion().request(Request::kArm);
  hand.turn();
  EXPECT_EQ(state(), GovernorState::kArmed) << told();
}

TEST(Motion, SaysWhichJointStandsFarOutsideItsLimits) {
  HandInMotion hand(exampleReady("leap"));
  const config::HandConfig& config = hand.motion().config();
  const safety::JointLimits& limits = config.governor.limits[0];
  hand.rig().put(0, config.motors[0].range_rad.upper + config.governor.outside.rad + 0.3);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.offer(0.4);
  hand.motion().request(Request::kArm);
  hand.turn();
  const double at = hand.state().position[0];
  EXPECT_EQ(hand.state().last_refusal.view(),
            fmt::format("ARM refused: measured far outside the limits: joint '{}' is at {:.4g} "
                        "rad, its limits {:.4g} to {:.4g}",
                        config.governor.names[0], at, limits.lower, limits.upper));
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST(Motion, OutOfSeveralJointsTheOneFarthestOutsideIsNamed) {
  safety::GovernorOptions options;
  options.names = {"a", "b", "c"};
  options.limits.resize(3, {.lower = 0, .upper = 1.5});
  options.outside.rad = 0.2;
  EXPECT_EQ(outsideText(options, std::vector{-0.1, 1.6, 0.5}).view(), "") << "by less";
  EXPECT_EQ(outsideText(options, std::vector{-0.3, 71.6, 0.5}).view(),
            "joint 'b' is at 71.6 rad, its limits 0 to 1.5");
}

TEST(Motion, WhatIsSaidOfAJointThatSlidesIsInMetres) {
  safety::GovernorOptions options;
  options.names = {"turn", "jaw"};
  options.limits = {{.lower = 0, .upper = 1.5},
                    {.lower = 0, .upper = 0.04, .slides = true, .travel = 0.012}};
  options.outside = {0.2, 2e-3};
  EXPECT_EQ(outsideText(options, std::vector{0.5, 0.0415}).view(), "") << "by less";
  EXPECT_EQ(outsideText(options, std::vector{1.75, 0.046}).view(),
            "joint 'jaw' is at 0.046 m, its limits 0 to 0.04");
  const Clamping told = clampingOf(options, std::vector{1.6, 0.052}, std::vector{1.5, 0.04});
  EXPECT_EQ(told.text.view(), "'jaw' asked for 0.052 m, given 0.04; 1 more joints less");
  EXPECT_NEAR(told.largest_rad, 1.0, 1e-12) << "of its motor";
}

TEST(Motion, AJawsForceIsItsMotorsTorqueOverItsTravel) {
  config::HandConfig config = exampleConfig("printed_gripper");
  config.motors[0].torque_Nm_A = 0.36;
  devices::DeviceState measured(1);
  measured.current[0] = 0.1;
  MotionState state(2, 1, 0);
  noteMotors(config, measured, {0}, state);
  EXPECT_NEAR(state.effort[0], 3.0, 1e-12) << "N";
  config.motors[0].torque_Nm_A.reset();
  noteMotors(config, measured, {0}, state);
  EXPECT_EQ(state.effort[0], 0.1) << "A";
  EXPECT_TRUE(std::isnan(state.effort[1])) << "it has no motor of its own";
}

TEST(Motion, WithoutHomingZerosAreFoundByTheWalkAlone) {
  config::HandConfig config = exampleReady("leap");
  config.calibration = "not_there.yaml";
  config.is_calibrated = false;
  HandInMotion hand(config);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.offer(0.4);
  hand.motion().request(Request::kArm);
  hand.turn();
  const std::string why =
      "zeros are not known: there is no calibration yet: `handgraft bridge check` makes one";
  EXPECT_EQ(hand.state().last_refusal.view(), "ARM refused: " + why);
  EXPECT_EQ(describe(hand.state()), "motors off; " + why);
}

TEST_P(EveryHandInMotion, CanBeArmedOnceItSaysThatItsMotorsAreOff) {
  ASSERT_TRUE(hand.start()) << told();
  hand.motion().request(Request::kDisarm);
  for (int k = 0; k < 300 && hand.state().is_powered; ++k)
    hand.turn();
  ASSERT_FALSE(hand.state().is_powered) << told();
  hand.motion().request(Request::kArm);
  hand.turn();
  EXPECT_EQ(state(), GovernorState::kArmed) << hand.state().last_refusal.view();
}

TEST_P(EveryHandInMotion, ForgetsARefusalOnceSomethingIsAccepted) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  hand.motion().request(Request::kReset);
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "RESET refused: nothing to reset");
  hand.offer(0.4);
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "RESET refused: nothing to reset")
      << "a pose does not answer a command";
  hand.motion().request(Request::kArm);
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "");
  hand.offer(std::vector<double>{0.1});
  hand.turn();
  EXPECT_NE(hand.state().last_refusal.view(), "");
  hand.offer(0.4);
  hand.turn();
  EXPECT_EQ(hand.state().last_refusal.view(), "") << "the newest pose is accepted";
  EXPECT_EQ(hand.state().refusals, 2u) << "but counted it stays";
}

TEST_P(EveryHandInMotion, ArrivesAndMeasuresWhereItIs) {
  ASSERT_TRUE(hand.start(0.5)) << told();
  hand.turnFor(25);
  ASSERT_EQ(state(), GovernorState::kArmed) << told();
  for (std::size_t i = 0; i < hand.state().position.size(); ++i) {
    const double followable = hand.state().target[i] - hand.state().residual[i];
    EXPECT_NEAR(hand.state().position[i], followable, 5e-3) << "joint " << i;
  }
}

TEST_P(EveryHandInMotion, MotorsStartWhereTheyStand) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  const std::vector<double> before = hand.angles();
  ASSERT_TRUE(hand.start(0.5)) << told();
  const config::HandConfig& config = hand.motion().config();
  for (int k = 0; k < 3; ++k)
    hand.turn();
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = 4 * config.governor.period_s * config.motors[i].velocity_rad_s;
    EXPECT_NEAR(hand.rig().goal(i), before[i], way) << "motor " << i;
  }
}

// A final pose comes again once it is diagnosed: the same joints under a new number.
TEST_P(EveryHandInMotion, ADiagnosedPoseChangesNothingOnTheWay) {
  std::vector<std::vector<double>> ways[2];
  for (const bool is_diagnosed : {false, true}) {
    HandInMotion one(exampleReady(GetParam()));
    ASSERT_TRUE(one.start(0.9)) << describe(one.state());
    for (int k = 0; k < 300; ++k) {
      if (is_diagnosed && k == 70) one.offer(0.9);
      one.turn();
      ways[is_diagnosed ? 1 : 0].push_back(one.state().command);
    }
    EXPECT_EQ(one.state().state, GovernorState::kArmed) << describe(one.state());
    EXPECT_EQ(one.state().poses_accepted, is_diagnosed ? 2u : 1u);
    EXPECT_EQ(one.state().poses_refused, 0u);
  }
  EXPECT_NE(ways[0].front(), ways[0].back()) << "it hardly moved";
  EXPECT_EQ(ways[0], ways[1]);
}

TEST_P(EveryHandInMotion, EndsWithItsMotorsOff) {
  auto one = std::make_unique<HandInMotion>(exampleReady(GetParam()));
  ASSERT_TRUE(one->start()) << describe(one->state());
  one->motion().switchOff();
  EXPECT_FALSE(one->rig().isPowered());
}

INSTANTIATE_TEST_SUITE_P(Examples,
                         EveryHandInMotion,
                         ::testing::ValuesIn(config::texts::example_configs),
                         [](const auto& told) {
                           return told.param;
                         });

}  // namespace
}  // namespace handgraft::bridge
