// The example configs in motion: armed when asked, and what the governor decides is what the
// devices are told.

#include "hardware/bridge/motion.h"

#include <random>

#include "tests/hardware/bridge/every_hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using test::EveryHandInMotion;
using test::exampleReady;
using test::HandInMotion;
using test::largestDifference;

TEST_P(EveryHandInMotion, StandsStillWithoutPowerUntilItIsArmed) {
  const std::vector<double> before = hand_.angles();
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  hand_.offer(0.9);
  hand_.turnFor(2);
  EXPECT_EQ(state(), GovernorState::kIdle);
  EXPECT_FALSE(hand_.rig().isPowered());
  EXPECT_EQ(hand_.angles(), before);
}

TEST_P(EveryHandInMotion, WhatIsSentIsTheGovernorsOutputWithinOneUnit) {
  if (!traits().has_own_loop)
    GTEST_SKIP() << "it is sent torques: EveryHandInAStorm compares where they lead to";
  const config::HandConfig config = hand_.motion().config();
  const std::unique_ptr<tendon::MotorMap> map = config::makeMotorMap(config);
  ASSERT_TRUE(hand_.start(0.6)) << told();
  hand_.turnFor(20);  // what the hand was off at first has faded
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  std::vector<double> motors(config.motors.size());
  std::vector<double> residual(config.jointCount());
  bool has_moved = false;
  for (int k = 0; k < 400; ++k) {
    if (k % 40 == 0) hand_.offer(share(random));
    const std::vector<double> before = hand_.state().command;
    hand_.turn();
    ASSERT_EQ(state(), GovernorState::kArmed) << told();
    has_moved = has_moved || hand_.state().command != before;
    map->command(hand_.state().command, motors, residual);
    for (std::size_t i = 0; i < motors.size(); ++i) {
      ASSERT_NEAR(hand_.rig().goal(i), motors[i], hand_.rig().unit(i)) << "motor " << i;
      EXPECT_GE(hand_.rig().goal(i), config.motors[i].range_rad.lower - 1e-6);
      EXPECT_LE(hand_.rig().goal(i), config.motors[i].range_rad.upper + 1e-6);
    }
    EXPECT_LT(largestDifference(hand_.state().residual, residual), 1e-9);
  }
  EXPECT_TRUE(has_moved);
}

TEST_P(EveryHandInMotion, SaysWhichJointKeepsItFromBeingArmed) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  const std::vector<std::string>& names = hand_.motion().config().governor.names;
  StreamPose pose;
  pose.stream = pose.sequence = 1;
  pose.arrived = hand_.now();
  pose.names = names;
  pose.names.back() = "tumb";
  pose.joint_rad.resize(names.size());
  hand_.motion().offer(pose);
  const std::string why =
      "wrong joint names: '" + names.back() + "' is missing, 'tumb' is none of its joints";
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "pose refused: " + why);
  hand_.motion().request(Request::kArm);
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "ARM refused: no fresh pose: " + why);
  EXPECT_FALSE(hand_.rig().isPowered());
  hand_.offer(0.4);
  hand_.motion().request(Request::kArm);
  hand_.turn();
  EXPECT_EQ(state(), GovernorState::kArmed) << told();
}

TEST_P(EveryHandInMotion, CanBeArmedOnceItSaysThatItsMotorsAreOff) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.motion().request(Request::kDisarm);
  for (int k = 0; k < 300 && hand_.state().is_powered; ++k)
    hand_.turn();
  ASSERT_FALSE(hand_.state().is_powered) << told();
  hand_.motion().request(Request::kArm);
  hand_.turn();
  EXPECT_EQ(state(), GovernorState::kArmed) << hand_.state().last_refusal.view();
}

TEST_P(EveryHandInMotion, ForgetsARefusalOnceSomethingIsAccepted) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  hand_.motion().request(Request::kReset);
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "RESET refused: nothing to reset");
  hand_.offer(0.4);
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "RESET refused: nothing to reset")
      << "a pose does not answer a command";
  hand_.motion().request(Request::kArm);
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "");
  hand_.offer(std::vector<double>{0.1});
  hand_.turn();
  EXPECT_NE(hand_.state().last_refusal.view(), "");
  hand_.offer(0.4);
  hand_.turn();
  EXPECT_EQ(hand_.state().last_refusal.view(), "") << "the newest pose is accepted";
  EXPECT_EQ(hand_.state().refusals, 2u) << "but counted it stays";
}

TEST_P(EveryHandInMotion, ArrivesAndMeasuresWhereItIs) {
  ASSERT_TRUE(hand_.start(0.5)) << told();
  hand_.turnFor(25);
  ASSERT_EQ(state(), GovernorState::kArmed) << told();
  for (std::size_t i = 0; i < hand_.state().position.size(); ++i) {
    const double followable = hand_.state().target[i] - hand_.state().residual[i];
    EXPECT_NEAR(hand_.state().position[i], followable, 5e-3) << "joint " << i;
  }
}

TEST_P(EveryHandInMotion, MotorsStartWhereTheyStand) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  const std::vector<double> before = hand_.angles();
  ASSERT_TRUE(hand_.start(0.5)) << told();
  const config::HandConfig& config = hand_.motion().config();
  for (int k = 0; k < 3; ++k)
    hand_.turn();
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = 4 * config.governor.period_s * config.motors[i].velocity_rad_s;
    EXPECT_NEAR(hand_.rig().goal(i), before[i], way) << "motor " << i;
  }
}

// A final pose comes again once it is diagnosed: the same joints under a new number.
TEST_P(EveryHandInMotion, ADiagnosedPoseChangesNothingOnTheWay) {
  std::vector<std::vector<double>> ways[2];
  for (const bool is_diagnosed : {false, true}) {
    HandInMotion hand(exampleReady(GetParam()));
    ASSERT_TRUE(hand.start(0.9)) << describe(hand.state());
    for (int k = 0; k < 300; ++k) {
      if (is_diagnosed && k == 70) hand.offer(0.9);
      hand.turn();
      ways[is_diagnosed ? 1 : 0].push_back(hand.state().command);
    }
    EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
    EXPECT_EQ(hand.state().poses_accepted, is_diagnosed ? 2u : 1u);
    EXPECT_EQ(hand.state().poses_refused, 0u);
  }
  EXPECT_NE(ways[0].front(), ways[0].back()) << "it hardly moved";
  EXPECT_EQ(ways[0], ways[1]);
}

TEST_P(EveryHandInMotion, EndsWithItsMotorsOff) {
  auto hand = std::make_unique<HandInMotion>(exampleReady(GetParam()));
  ASSERT_TRUE(hand->start()) << describe(hand->state());
  hand->motion().switchOff();
  EXPECT_FALSE(hand->rig().isPowered());
}

INSTANTIATE_TEST_SUITE_P(
    Examples,
    EveryHandInMotion,
    ::testing::Values("leap", "ability_hand", "printed_tendon_hand", "inspire_rh56", "allegro"),
    [](const auto& told) {
      return told.param;
    });

}  // namespace
}  // namespace handgraft::bridge
