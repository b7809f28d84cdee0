// Zeros: found by homing, void when it fails or the device forgot them, and never trusted where
// motors stand outside their range.

#include <limits>
#include <numbers>
#include <optional>

#include "tests/hardware/bridge/every_hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using test::exampleReady;
using test::HandInMotion;

// === Homing

TEST(Homing, ArmingAnUnhomedHandIsRefused) {
  HandInMotion hand(test::exampleConfig("printed_tendon_hand"));
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle));
  hand.offer(0.5);
  hand.motion().request(Request::kArm);
  hand.turnFor(0.5);
  EXPECT_EQ(hand.state().state, GovernorState::kIdle);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_NE(hand.state().last_refusal.view().find("HOME"), std::string_view::npos);
}

TEST(Homing, FindsTheZerosOfEveryMotor) {
  const config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  std::vector<std::optional<config::HandConfig>> told;
  HandInMotion hand(config, [&](const config::HandConfig* homed) {
    told.push_back(homed ? std::optional(*homed) : std::nullopt);
  });
  // The third drum counts the other way.
  const std::vector<double> taut = handgraft::test::slackenLines(hand.rig(), config);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turn();
  EXPECT_TRUE(hand.state().is_homing);
  for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
    hand.turn();
  ASSERT_EQ(told.size(), 2) << describe(hand.state());
  EXPECT_FALSE(told[0]) << "what was known is void from the beginning";
  // Lines stretch, by what the device's own limit of the current permits.
  const std::vector<double> zeros = handgraft::test::zerosOfShafts(hand.rig(), *told[1]);
  for (std::size_t i = 0; i < taut.size(); ++i) {
    const double pull_A = 1.25 * config.homing[i].current_A - 0.25;
    const double stretch_rad =
        2 * std::numbers::pi * pull_A / handgraft::test::ODriveEmulator::kTautCurrent;
    EXPECT_LT(std::abs(zeros[i] - taut[i]), stretch_rad + 1e-3) << "motor " << i;
  }
  EXPECT_TRUE(hand.state().is_homed);
  EXPECT_FALSE(hand.rig().isPowered());
  hand.turnFor(0.1);  // it is measured from its new zeros
  ASSERT_EQ(hand.state().state, GovernorState::kIdle) << describe(hand.state());
  EXPECT_TRUE(hand.start(0.5)) << "homed, it can be armed: " << describe(hand.state()) << ", "
                               << hand.state().last_refusal.view();
}

// Before zeros are known a motor's own range says nothing: it must not be sent there.
TEST(Homing, TheOtherMotorsHoldWhereTheyStandBeItOutsideTheirRange) {
  const config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand(config);
  handgraft::test::ODriveEmulator& bus = busOf(hand.rig());
  for (const int node : {1, 2}) {
    auto& servo = bus.axis(node).servo;
    servo.position = servo.goal = node == 1 ? -2.3 : 3.1;  // turns
  }
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turnFor(3);
  ASSERT_TRUE(hand.state().is_homing) << describe(hand.state());
  EXPECT_GT(bus.axis(0).servo.position, 0.1) << "turns";
  EXPECT_NEAR(bus.axis(1).servo.position, -2.3, 1e-5);
  EXPECT_NEAR(bus.axis(2).servo.position, 3.1, 1e-5);
}

TEST(Homing, AMotorThatDoesNotTellItsCurrentIsNotHomed) {
  HandInMotion hand(test::exampleConfig("printed_tendon_hand"));
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  busOf(hand.rig()).axis(0).current_A = std::numeric_limits<float>::quiet_NaN();
  hand.motion().request(Request::kHome);
  for (int k = 0; k < 10; ++k)
    hand.turn();
  EXPECT_FALSE(hand.state().is_homing);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_NE(hand.state().trouble.view().find("current"), std::string_view::npos)
      << describe(hand.state());
}

TEST(Homing, FailsWithTheMotorsOffWhereThereIsNoStop) {
  config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand(config);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turn();
  for (int k = 0; k < 8000 && hand.state().is_homing; ++k)
    hand.turn();
  EXPECT_FALSE(hand.state().is_homing);
  EXPECT_FALSE(hand.state().is_homed);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_NE(hand.state().trouble.view().find("found no stop"), std::string_view::npos)
      << describe(hand.state());
}

TEST(Homing, TheDeviceItselfLimitsCurrentAndSpeedWhileItRuns) {
  const config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand(config);
  handgraft::test::slackenLines(hand.rig(), config);
  handgraft::test::ODriveEmulator& bus = busOf(hand.rig());
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  EXPECT_EQ(bus.axis(0).current_limit_A, config.motors[0].current_A);
  hand.motion().request(Request::kHome);
  hand.turnFor(1.5);
  ASSERT_TRUE(hand.state().is_homing);
  EXPECT_NEAR(bus.axis(0).current_limit_A, 1.25 * config.homing[0].current_A, 1e-6);
  EXPECT_NEAR(bus.axis(0).servo.speed,
              1.5 * config.homing[0].speed_rad_s / (2 * std::numbers::pi), 1e-6);
  for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
    hand.turn();
  ASSERT_TRUE(hand.state().is_homed) << describe(hand.state());
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const auto& axis = bus.axis(config.motors[i].id);
    EXPECT_LE(axis.largest_current_A, 1.25 * config.homing[i].current_A + 1e-6);
    EXPECT_EQ(axis.current_limit_A, config.motors[i].current_A) << "set back";
  }
}

// The same on Dynamixels, whose goal current and profile they are.
TEST(Homing, ADynamixelItselfLimitsCurrentAndSpeedWhileItRuns) {
  config::HandConfig config = test::exampleConfig("leap");
  safety::HomingStep step;
  step.motor = 1;
  step.toward = 1;
  step.speed_rad_s = 0.5;
  step.current_A = 0.15;
  step.travel_rad = 3;
  step.stop_rad = config.motors[1].range_rad.upper;
  step.back_off_rad = 0.2;
  config.homing = {step};
  HandInMotion hand(config);
  auto& emulator = dynamic_cast<handgraft::test::DynamixelEmulator&>(hand.rig().emulated());
  auto& motor = emulator.motor(1);
  const double stop_rad = 1.1;  // by the config's zero, which is wrong
  motor.stop = 2048 + stop_rad / protocols::dynamixel::kRadPerCount;
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  const auto usual_profile = emulator.get(1, "profile_velocity");
  hand.motion().request(Request::kHome);
  hand.turnFor(1);
  ASSERT_TRUE(hand.state().is_homing) << describe(hand.state());
  EXPECT_EQ(emulator.get(1, "goal_current"), 188) << "mA: a quarter more than it is told";
  EXPECT_EQ(emulator.get(2, "goal_current"), 350) << "of a motor that holds";
  const double highest_rad_s = static_cast<double>(emulator.get(1, "profile_velocity")) *
                               protocols::dynamixel::kVelocityUnit;
  EXPECT_NEAR(highest_rad_s, 1.5 * step.speed_rad_s, protocols::dynamixel::kVelocityUnit);
  for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
    hand.turn();
  ASSERT_TRUE(hand.state().is_homed) << describe(hand.state());
  EXPECT_EQ(motor.largest_current_limit, 188);
  EXPECT_EQ(emulator.get(1, "profile_velocity"), usual_profile) << "set back";
  const double off_rad = stop_rad - step.stop_rad;
  EXPECT_NEAR(hand.motion().config().motors[1].zero_rad, std::numbers::pi + off_rad, 0.02);
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  EXPECT_EQ(emulator.get(1, "goal_current"), 350) << "set back";
}

// Limits that a zero puts beyond the device's own units, as found in the motion's thread.
TEST(Homing, ZerosThatTheDeviceRefusesAreToldAndTheHandGoesOnWithout) {
  const config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  bool was_kept = false;
  HandInMotion hand(config, [&was_kept](const config::HandConfig* homed) {
    was_kept = homed != nullptr;
  });
  handgraft::test::slackenLines(hand.rig(), config);
  hand.before_making = [&config,
                        count = config.motors.size()](const config::HandConfig& asked) {
    if (asked.motors[count - 1].zero_rad != config.motors[count - 1].zero_rad)
      rejectInput("motor {}: limits are outside", count - 1);
  };
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turn();
  for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
    hand.turn();
  EXPECT_FALSE(hand.state().is_homed);
  EXPECT_FALSE(was_kept);
  EXPECT_EQ(hand.state().trouble.view(),
            "its new zeros are refused: motor 2: limits are outside");
  hand.turnFor(1);
  EXPECT_EQ(hand.state().state, GovernorState::kIdle) << "it goes on";
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST(Homing, AMotorThatStopsTellingItsCurrentIsNotRunOn) {
  const config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand(config);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turnFor(2);
  ASSERT_TRUE(hand.state().is_homing);
  busOf(hand.rig()).axis(0).tells_current = false;
  const double before = hand.rig().angle(0);
  for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
    hand.turn();
  EXPECT_FALSE(hand.state().is_homed);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_LT(std::abs(hand.rig().angle(0) - before), 0.1) << "of 12 rad that it was given";
}

TEST(Homing, ItsFailureVoidsWhatWasKnownAndSaysHowFarItWent) {
  config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  config.is_calibrated = true;
  for (config::MotorConfig& motor : config.motors) {
    motor.is_marked = true;
    motor.zero_rad = 251;  // far from 0, as a mark is
  }
  HandInMotion hand(config);
  for (const config::MotorConfig& motor : config.motors)
    busOf(hand.rig()).axis(motor.id).counts_from = 251 / (2 * std::numbers::pi);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  ASSERT_TRUE(hand.state().is_homed) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turn();
  EXPECT_FALSE(hand.state().is_homed);
  for (int k = 0; k < 8000 && hand.state().is_homing; ++k)
    hand.turn();
  EXPECT_FALSE(hand.state().is_homed);
  for (const char* part : {"homing of 'thumb'", "found no stop", "of 12 rad", "0.25 A at most"})
    EXPECT_NE(describe(hand.state()).find(part), std::string::npos) << describe(hand.state());
  hand.offer(0.5);
  hand.motion().request(Request::kArm);
  hand.turnFor(0.5);
  EXPECT_FALSE(hand.rig().isPowered());
}

// === Zeros that an incremental encoder lost with its power

/// A tendon hand that was homed.
class HomedHand : public ::testing::Test {
 protected:
  void home(bool takes_marks) {
    handgraft::test::slackenLines(hand.rig(), config);
    for (const config::MotorConfig& motor : config.motors)
      busOf(hand.rig()).axis(motor.id).takes_positions = takes_marks;
    ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
    hand.motion().request(Request::kHome);
    hand.turn();
    for (int k = 0; k < 6000 && hand.state().is_homing; ++k)
      hand.turn();
    ASSERT_TRUE(hand.state().is_homed) << describe(hand.state());
    hand.turnFor(0.2);
  }

  void expectIsNotArmed(const char* why) {
    hand.offer(0.0);
    hand.motion().request(Request::kArm);
    hand.turnFor(1);
    EXPECT_FALSE(hand.rig().isPowered()) << describe(hand.state());
    EXPECT_FALSE(hand.state().is_homed);
    EXPECT_NE(hand.state().last_refusal.view().find(why), std::string_view::npos)
        << hand.state().last_refusal.view();
  }

  config::HandConfig config = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand{config};
};

TEST_F(HomedHand, WhoseAxisRestartedWhileItWasIdleIsNotArmed) {
  home(true);
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  hand.motion().request(Request::kDisarm);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle));
  busOf(hand.rig()).restart(1);
  hand.turnFor(2);
  if (hand.state().state == GovernorState::kFault) hand.motion().request(Request::kReset);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.turnFor(0.5);
  expectIsNotArmed("motor 'index' restarted");
}

TEST_F(HomedHand, WhoseAxisRestartedUnderPowerIsNotArmedAgain) {
  home(true);
  ASSERT_TRUE(hand.start(0.5)) << describe(hand.state());
  hand.turnFor(1);
  busOf(hand.rig()).restart(2);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kFault));
  hand.turnFor(1);
  hand.motion().request(Request::kReset);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.turnFor(0.5);
  expectIsNotArmed("motor 'others' restarted");
}

TEST_F(HomedHand, ThatCannotSayWhetherItRestartedIsVoidOnceItWasAway) {
  home(false);
  ASSERT_TRUE(hand.start(0.5)) << "it was heard of all the time";
  hand.motion().request(Request::kDisarm);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle));
  hand.rig().wire().unplug();
  hand.turnFor(1);
  hand.rig().wire().plug();
  hand.turnFor(1);
  hand.motion().request(Request::kReset);
  hand.turnFor(2);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  expectIsNotArmed("motor 'thumb' cannot say whether it restarted");
}

TEST_F(HomedHand, KeepsItsZerosThroughAnEmergencyStop) {
  home(false);
  ASSERT_TRUE(hand.start(0.5));
  hand.motion().estop();
  hand.turnFor(2);
  hand.motion().request(Request::kReset);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.turnFor(0.2);
  EXPECT_TRUE(hand.start(0.4)) << describe(hand.state()) << ", "
                               << hand.state().last_refusal.view();
}

TEST(Zeros, AMotorOutsideItsOwnRangeIsNotArmedWhateverTheJointsSay) {
  config::HandConfig config = exampleReady("printed_tendon_hand");
  HandInMotion hand(config);
  // Unwound by two thirds of a turn: slack lines, so that every joint is measured at rest.
  auto& servo = busOf(hand.rig()).axis(1).servo;
  servo.position = servo.goal = -0.65;
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.offer(0.0);
  hand.motion().request(Request::kArm);
  hand.turnFor(0.5);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_EQ(hand.state().last_refusal.view(),
            "ARM refused: a motor stands far outside its range: 'index' is at -4.08 rad, its "
            "range 0 to 6");
}

TEST(Homing, AnEmergencyStopEndsIt) {
  HandInMotion hand(test::exampleConfig("printed_tendon_hand"));
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
  hand.motion().request(Request::kHome);
  hand.turnFor(2);
  ASSERT_TRUE(hand.state().is_homing);
  ASSERT_TRUE(hand.rig().isPowered());
  hand.motion().estop();
  hand.turn();
  EXPECT_EQ(hand.state().state, GovernorState::kEStop);
  EXPECT_FALSE(hand.state().is_homing);
  EXPECT_FALSE(hand.rig().isPowered());
}

}  // namespace
}  // namespace handgraft::bridge
