// The example configs in motion, on emulated devices and in virtual time: what the governor
// decides is what the devices are told, and what goes wrong with a device ends as it should.

#include "hardware/bridge/motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/bridge/telemetry.h"

#include "tests/hardware/bridge/hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::FaultCause;
using safety::GovernorState;
using safety::HoldCause;
using std::chrono::milliseconds;
using test::HandInMotion;

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

config::HandConfig exampleReady(const std::string& name) {
  config::HandConfig config = test::exampleConfig(name);
  config.homing.clear();  // as if it had been homed
  return config;
}

class EveryHandInMotion : public ::testing::TestWithParam<std::string> {
 protected:
  EveryHandInMotion() : hand_(exampleReady(GetParam())) {}

  [[nodiscard]] GovernorState state() const { return hand_.state().state; }

  [[nodiscard]] std::string told() const { return describe(hand_.state()); }

  void expectOffForGood() {
    hand_.rig().wire().pass(milliseconds(500));
    EXPECT_FALSE(hand_.rig().isPowered());
    const std::vector<double> before = hand_.angles();
    hand_.offer(0.9);
    hand_.motion().request(Request::kArm);
    hand_.turnFor(0.5);
    EXPECT_LT(largestDifference(before, hand_.angles()), 1e-9) << "it moved: " << told();
  }

  HandInMotion hand_;
};

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

// === What must end motion

TEST_P(EveryHandInMotion, HoldsOnAStaleStreamThenGoesOffAndStays) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.turnFor(0.3);
  hand_.is_streaming = false;
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kHolding, 0.7)) << told();
  EXPECT_EQ(hand_.state().hold, HoldCause::kStale);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand_.rig().isPowered());
  hand_.is_streaming = true;
  hand_.offer(0.9);
  hand_.turnFor(1);
  EXPECT_EQ(state(), GovernorState::kIdle) << "a returning stream resumes nothing";
}

TEST_P(EveryHandInMotion, AnotherStreamMakesItHold) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.turnFor(0.1);
  hand_.stream = 2;
  hand_.offer(0.8);
  hand_.turn();
  EXPECT_EQ(state(), GovernorState::kHolding);
  EXPECT_EQ(hand_.state().hold, HoldCause::kStreamChanged);
}

TEST_P(EveryHandInMotion, ASilentDeviceIsAFault) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.rig().emulated().ailments.is_mute = true;
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kFault, 2)) << told();
  EXPECT_EQ(wireFault(hand_.state()), v1::FAULT_SILENT) << told();
  expectOffForGood();
}

TEST_P(EveryHandInMotion, AnswersThatAlwaysComeLateAreAFault) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.rig().emulated().ailments.delay = milliseconds(30);
  const bool is_fault = hand_.turnUntil(GovernorState::kFault, 2);
  // Answers without numbers may be taken for the next question's: those of a bus that is
  // always late by the same time are old, but true. Then nothing may be wrong with the motion.
  if (is_fault) expectOffForGood();
  EXPECT_TRUE(is_fault || largestDifference(hand_.state().position, hand_.state().target) < 1);
}

TEST_P(EveryHandInMotion, BearsRepeatedAnswersAndGarbage) {
  ASSERT_TRUE(hand_.start(0.5)) << told();
  hand_.rig().emulated().ailments.repeats = true;
  hand_.rig().emulated().ailments.garbage_rate = 0.03;  // a line of text is lost by it
  hand_.turnFor(2);
  EXPECT_EQ(state(), GovernorState::kArmed) << told();
}

TEST_P(EveryHandInMotion, AnErrorThatTheDeviceTellsEndsMotion) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.rig().breakDown();
  if (GetParam() == "ability_hand") {
    // It says only that a motor is held back: it holds, then goes off.
    ASSERT_TRUE(hand_.turnUntil(GovernorState::kHolding, 2)) << told();
    EXPECT_EQ(hand_.state().hold, HoldCause::kMotorLimited);
    return;
  }
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kFault, 2)) << told();
  EXPECT_EQ(wireFault(hand_.state()), v1::FAULT_HARDWARE) << told();
  expectOffForGood();
  hand_.motion().request(Request::kReset);
  hand_.turnFor(5);
  EXPECT_EQ(state(), GovernorState::kFault) << "the cause is still there";
  hand_.rig().heal();
  hand_.motion().request(Request::kReset);
  EXPECT_TRUE(hand_.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand_.rig().isPowered());
}

TEST_P(EveryHandInMotion, SuspendedTheDevicesOwnWatchdogStopsItAndItStaysOff) {
  ASSERT_TRUE(hand_.start(0.9)) << told();
  hand_.turnFor(0.2);
  hand_.rig().wire().pass(std::chrono::seconds(2));  // as by SIGSTOP
  EXPECT_FALSE(hand_.rig().isPowered());
  hand_.turn();
  hand_.turn();
  EXPECT_EQ(state(), GovernorState::kFault) << told();
  EXPECT_EQ(wireFault(hand_.state()), v1::FAULT_LATE) << told();
  expectOffForGood();
}

TEST_P(EveryHandInMotion, UnpluggedAndPluggedInAgainItStaysDisarmed) {
  ASSERT_TRUE(hand_.start()) << told();
  hand_.rig().wire().unplug();
  hand_.turn();
  hand_.turn();
  EXPECT_EQ(state(), GovernorState::kFault) << told();
  EXPECT_EQ(wireFault(hand_.state()), v1::FAULT_WIRE) << told();
  hand_.turnFor(1);
  hand_.rig().wire().plug();
  hand_.turnFor(3);
  EXPECT_EQ(state(), GovernorState::kFault);
  hand_.motion().request(Request::kReset);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  hand_.turnFor(1);
  EXPECT_FALSE(hand_.rig().isPowered());
  EXPECT_TRUE(hand_.start(0.5)) << told();
}

TEST_P(EveryHandInMotion, PluggedInLateItIsFoundAndStaysOff) {
  hand_.rig().wire().unplug();
  hand_.turnFor(3);
  EXPECT_EQ(state(), GovernorState::kDisconnected);
  EXPECT_FALSE(hand_.state().trouble.view().empty());
  hand_.rig().wire().plug();
  EXPECT_TRUE(hand_.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand_.rig().isPowered());
}

TEST_P(EveryHandInMotion, AnEmergencyStopAtAnyTickBrakesAndSwitchesOff) {
  std::mt19937 random(11);
  for (int run = 0; run < 5; ++run) {
    HandInMotion hand(exampleReady(GetParam()));
    ASSERT_TRUE(hand.start(0.9)) << describe(hand.state());
    const auto wait = static_cast<int>(random() % 120);
    for (int k = 0; k < wait; ++k)
      hand.turn();
    hand.motion().estop();
    const devices::TimePoint asked = hand.now();
    std::vector<double> last = hand.state().command;
    while (hand.state().is_powered && hand.now() - asked < std::chrono::seconds(3)) {
      hand.turn();
      EXPECT_EQ(hand.state().state, GovernorState::kEStop);
      const config::HandConfig& config = hand.motion().config();
      for (std::size_t i = 0; hand.state().is_powered && i < last.size(); ++i) {
        const double step = config.governor.limits[i].velocity * config.governor.period_s;
        EXPECT_LE(std::abs(hand.state().command[i] - last[i]), step * (1 + 1e-6));
      }
      last = hand.state().command;
    }
    EXPECT_LE(hand.now() - asked,
              hand.motion().config().governor.brake_within + milliseconds(200));
    EXPECT_FALSE(hand.rig().isPowered());
    hand.offer(0.1);
    hand.motion().request(Request::kArm);
    hand.turnFor(0.3);
    EXPECT_EQ(hand.state().state, GovernorState::kEStop) << "latched";
    hand.motion().request(Request::kReset);
    EXPECT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
    EXPECT_FALSE(hand.rig().isPowered());
  }
}

TEST_P(EveryHandInMotion, AnEmergencyStopByCutIsTheNextThingTheDeviceHears) {
  config::HandConfig config = exampleReady(GetParam());
  config.governor.stop_mode = safety::StopMode::kCut;
  HandInMotion hand(config);
  ASSERT_TRUE(hand.start(0.9)) << describe(hand.state());
  hand.turnFor(0.3);
  const std::vector<double> before = hand.angles();
  hand.motion().estop();
  hand.turn();
  EXPECT_FALSE(hand.rig().isPowered());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = 3 * config.governor.period_s * config.motors[i].velocity_rad_s;
    EXPECT_NEAR(hand.angles()[i], before[i], way);
  }
  hand.turn();  // the device says that it is off
  hand.motion().request(Request::kReset);
  EXPECT_TRUE(hand.turnUntil(GovernorState::kIdle)) << describe(hand.state());
}

TEST_P(EveryHandInMotion, AnEmergencyStopDoesNotWaitUntilMotorsAreOn) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  hand_.rig().emulated().ailments.delay = milliseconds(2);  // so that arming takes its time
  int gave_way = 0;
  for (const int delay_ms : {0, 1, 4, 15, 40, 80}) {
    hand_.turn();
    hand_.offer(0.5);
    hand_.motion().request(Request::kArm);
    hand_.stop_asked_at = hand_.now() + milliseconds(delay_ms);
    hand_.motion().turn();
    if (hand_.now() < *hand_.stop_asked_at) break;  // it is not that slow
    ++gave_way;
    EXPECT_LE(hand_.now() - *hand_.stop_asked_at, milliseconds(50)) << delay_ms;
    EXPECT_FALSE(hand_.rig().isPowered()) << delay_ms;
    hand_.stop_asked_at.reset();
    hand_.motion().estop();  // as the motion's thread does before the next turn
    hand_.turn();
    EXPECT_EQ(state(), GovernorState::kEStop) << told();
    EXPECT_FALSE(hand_.rig().isPowered());
    hand_.turn();
    hand_.motion().request(Request::kReset);
    ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << told();
  }
  EXPECT_GE(gave_way, GetParam() == "ability_hand" ? 1 : 4);
}

// A final pose comes again once it is explained: the same joints under a new number.
TEST_P(EveryHandInMotion, AnExplainedPoseChangesNothingOnTheWay) {
  std::vector<std::vector<double>> ways[2];
  for (const bool is_explained : {false, true}) {
    HandInMotion hand(exampleReady(GetParam()));
    ASSERT_TRUE(hand.start(0.9)) << describe(hand.state());
    for (int k = 0; k < 300; ++k) {
      if (is_explained && k == 70) hand.offer(0.9);
      hand.turn();
      ways[is_explained ? 1 : 0].push_back(hand.state().command);
    }
    EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
    EXPECT_EQ(hand.state().poses_accepted, is_explained ? 2u : 1u);
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

INSTANTIATE_TEST_SUITE_P(Examples,
                         EveryHandInMotion,
                         ::testing::Values("leap", "ability_hand", "printed_tendon_hand"),
                         [](const auto& told) {
                           return told.param;
                         });

// === Motors that are held back

class HeldBack : public ::testing::Test {
 protected:
  handgraft::test::DynamixelEmulator& emulator() {
    return dynamic_cast<handgraft::test::DynamixelEmulator&>(hand_.rig().emulated());
  }

  HandInMotion hand_{[] {
    config::HandConfig config = exampleReady("leap");
    config.stalled_for = milliseconds(2000);
    return config;
  }()};
};

TEST_F(HeldBack, AHotMotorHoldsThenGoesOffAndIsNamed) {
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  emulator().set(5, "temperature", 66);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kHolding, 3)) << describe(hand_.state());
  EXPECT_EQ(hand_.state().hold, HoldCause::kMotorLimited);
  EXPECT_EQ(describe(hand_.state()),
            "motor 'middle_forward' is hot: 66 degrees C; ARM moves on");
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle, 3));
  EXPECT_FALSE(hand_.rig().isPowered());
}

TEST_F(HeldBack, AMotorThatPushesInVainForLongHoldsThenGoesOff) {
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  hand_.turnFor(1);
  emulator().set(2, "present_current", 349);  // of 350
  hand_.turnFor(1.5);
  EXPECT_EQ(hand_.state().state, GovernorState::kArmed) << "a grasp may be held for a while";
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kHolding, 4)) << describe(hand_.state());
  EXPECT_NE(describe(hand_.state()).find("motor 'index_pip' is stalled"), std::string::npos)
      << describe(hand_.state());
}

TEST_F(HeldBack, AMotorThatMovesAndPushesIsNotStalled) {
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  for (int k = 0; k < 400; ++k) {
    emulator().set(2, "present_current", k % 100 < 95 ? 349 : 100);
    hand_.turn();
  }
  EXPECT_EQ(hand_.state().state, GovernorState::kArmed) << describe(hand_.state());
}

TEST_F(HeldBack, EffortsAreCurrentsTimesTheTorqueConstant) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle));
  emulator().set(2, "present_current", 200);
  hand_.turnFor(0.1);
  EXPECT_NEAR(hand_.state().motor_current[2], 0.2, 1e-9);
  EXPECT_NEAR(hand_.state().effort[2], 0.2, 1e-9) << "in A where nothing is told";
}

TEST_F(HeldBack, AFaultNamesMotorAndWords) {
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  emulator().fail(3, protocols::dynamixel::kOverload);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kFault, 1));
  EXPECT_EQ(describe(hand_.state()),
            "motor 'index_dip' (id 3, joint '3'): hardware error: overload (code 0x20); RESET, "
            "then ARM, to move again");
}

TEST_F(HeldBack, AClampedPoseIsToldWithWhatWasAskedAndGiven) {
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle));
  std::vector<double> pose(16, 0.0);
  pose[2] = 3.685;
  pose[5] = 2.5;
  hand_.offer(pose);
  hand_.turn();
  EXPECT_EQ(hand_.state().clamping.view(),
            "'2' asked for 3.685 rad, given 1.885; 1 more joints less");
  EXPECT_NEAR(hand_.state().clamped_rad, 1.8, 1e-3);
  hand_.offer(0.5);
  EXPECT_TRUE(hand_.state().clamping.view().empty());
}

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
    handgraft::test::slackenLines(hand_.rig(), config_);
    for (const config::MotorConfig& motor : config_.motors)
      busOf(hand_.rig()).axis(motor.id).takes_positions = takes_marks;
    ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << describe(hand_.state());
    hand_.motion().request(Request::kHome);
    hand_.turn();
    for (int k = 0; k < 6000 && hand_.state().is_homing; ++k)
      hand_.turn();
    ASSERT_TRUE(hand_.state().is_homed) << describe(hand_.state());
    hand_.turnFor(0.2);
  }

  void expectIsNotArmed(const char* why) {
    hand_.offer(0.0);
    hand_.motion().request(Request::kArm);
    hand_.turnFor(1);
    EXPECT_FALSE(hand_.rig().isPowered()) << describe(hand_.state());
    EXPECT_FALSE(hand_.state().is_homed);
    EXPECT_NE(hand_.state().last_refusal.view().find(why), std::string_view::npos)
        << hand_.state().last_refusal.view();
  }

  config::HandConfig config_ = test::exampleConfig("printed_tendon_hand");
  HandInMotion hand_{config_};
};

TEST_F(HomedHand, WhoseAxisRestartedWhileItWasIdleIsNotArmed) {
  home(true);
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  hand_.motion().request(Request::kDisarm);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle));
  busOf(hand_.rig()).restart(1);
  hand_.turnFor(2);
  if (hand_.state().state == GovernorState::kFault) hand_.motion().request(Request::kReset);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << describe(hand_.state());
  hand_.turnFor(0.5);
  expectIsNotArmed("motor 'index' restarted");
}

TEST_F(HomedHand, WhoseAxisRestartedUnderPowerIsNotArmedAgain) {
  home(true);
  ASSERT_TRUE(hand_.start(0.5)) << describe(hand_.state());
  hand_.turnFor(1);
  busOf(hand_.rig()).restart(2);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kFault));
  hand_.turnFor(1);
  hand_.motion().request(Request::kReset);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << describe(hand_.state());
  hand_.turnFor(0.5);
  expectIsNotArmed("motor 'others' restarted");
}

TEST_F(HomedHand, ThatCannotSayWhetherItRestartedIsVoidOnceItWasAway) {
  home(false);
  ASSERT_TRUE(hand_.start(0.5)) << "it was heard of all the time";
  hand_.motion().request(Request::kDisarm);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle));
  hand_.rig().wire().unplug();
  hand_.turnFor(1);
  hand_.rig().wire().plug();
  hand_.turnFor(1);
  hand_.motion().request(Request::kReset);
  hand_.turnFor(2);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << describe(hand_.state());
  expectIsNotArmed("motor 'thumb' cannot say whether it restarted");
}

TEST_F(HomedHand, KeepsItsZerosThroughAnEmergencyStop) {
  home(false);
  ASSERT_TRUE(hand_.start(0.5));
  hand_.motion().estop();
  hand_.turnFor(2);
  hand_.motion().request(Request::kReset);
  ASSERT_TRUE(hand_.turnUntil(GovernorState::kIdle)) << describe(hand_.state());
  hand_.turnFor(0.2);
  EXPECT_TRUE(hand_.start(0.4)) << describe(hand_.state()) << ", "
                                << hand_.state().last_refusal.view();
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
