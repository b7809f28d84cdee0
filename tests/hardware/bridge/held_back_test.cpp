// Motors that are hot, or push in vain, and what is told of motors and clamped poses.

#include "tests/hardware/bridge/every_hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using safety::HoldCause;
using std::chrono::milliseconds;
using test::exampleReady;
using test::HandInMotion;

// === Motors that are held back

class HeldBack : public ::testing::Test {
 protected:
  handgraft::test::DynamixelEmulator& emulator() {
    return dynamic_cast<handgraft::test::DynamixelEmulator&>(hand.rig().emulated());
  }

  HandInMotion hand{[] {
    config::HandConfig config = exampleReady("leap");
    config.stalled_for = milliseconds(2000);
    return config;
  }()};
};

TEST_F(HeldBack, AHotMotorHoldsThenGoesOffAndIsNamed) {
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  emulator().set(5, "temperature", 66);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 3)) << describe(hand.state());
  EXPECT_EQ(hand.state().hold, HoldCause::kMotorLimited);
  EXPECT_EQ(describe(hand.state()),
            "motor 'middle_forward' is hot: 66 degrees C; ARM moves on");
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle, 3));
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST_F(HeldBack, AMotorThatPushesInVainForLongHoldsThenGoesOff) {
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  hand.turnFor(1);
  emulator().set(2, "present_current", 349);  // of 350
  hand.turnFor(1.5);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << "a grasp may be held for a while";
  ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 4)) << describe(hand.state());
  EXPECT_NE(describe(hand.state()).find("motor 'index_pip' is stalled"), std::string::npos)
      << describe(hand.state());
}

TEST_F(HeldBack, AMotorThatMovesAndPushesIsNotStalled) {
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  for (int k = 0; k < 400; ++k) {
    emulator().set(2, "present_current", k % 100 < 95 ? 349 : 100);
    hand.turn();
  }
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
}

// The same on ODrive axes, whose firmware would go on up to its own limits.
TEST(HeldBackODrive, AHotAxisHoldsThenGoesOffAndIsNamed) {
  HandInMotion hand(exampleReady("printed_tendon_hand"));
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  busOf(hand.rig()).axis(1).heat = {80.0f, 40.0f};
  ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 3)) << describe(hand.state());
  EXPECT_EQ(hand.state().hold, HoldCause::kMotorLimited);
  EXPECT_EQ(describe(hand.state()), "motor 'index' is hot: 80 degrees C; ARM moves on");
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle, 3)) << describe(hand.state());
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST(HeldBackODrive, AnAxisThatPushesInVainForLongHoldsThenGoesOff) {
  config::HandConfig config = exampleReady("printed_tendon_hand");
  config.stalled_for = milliseconds(2000);
  HandInMotion hand(config);
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  hand.turnFor(25);  // it has arrived
  busOf(hand.rig()).axis(2).current_A = static_cast<float>(0.99 * config.motors[2].current_A);
  hand.turnFor(1.5);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
  ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 4)) << describe(hand.state());
  EXPECT_NE(describe(hand.state()).find("motor 'others' is stalled"), std::string::npos)
      << describe(hand.state());
}

TEST_F(HeldBack, EffortsAreCurrentsTimesTheTorqueConstant) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle));
  emulator().set(2, "present_current", 200);
  hand.turnFor(0.1);
  EXPECT_NEAR(hand.state().motor_current[2], 0.2, 1e-9);
  EXPECT_NEAR(hand.state().effort[2], 0.2, 1e-9) << "in A where nothing is told";
}

TEST_F(HeldBack, AFaultNamesMotorAndWords) {
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  emulator().fail(3, protocols::dynamixel::kOverload);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kFault, 1));
  EXPECT_EQ(describe(hand.state()),
            "motor 'index_dip' (id 3, joint '3'): hardware error: overload (code 0x20); RESET, "
            "then ARM, to move again");
}

TEST_F(HeldBack, AClampedPoseIsToldWithWhatWasAskedAndGiven) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle));
  std::vector<double> pose(16, 0.0);
  pose[2] = 3.685;
  pose[5] = 2.5;
  hand.offer(pose);
  hand.turn();
  EXPECT_EQ(hand.state().clamping.view(),
            "'2' asked for 3.685 rad, given 1.885; 1 more joints less");
  EXPECT_NEAR(hand.state().clamped_rad, 1.8, 1e-3);
  hand.offer(0.5);
  EXPECT_TRUE(hand.state().clamping.view().empty());
}

}  // namespace
}  // namespace handgraft::bridge
