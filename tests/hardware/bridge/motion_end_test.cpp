// What must end the motion of every hand: streams, devices and people that stop it.

#include <random>

#include "tests/hardware/bridge/every_hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using safety::HoldCause;
using std::chrono::milliseconds;
using test::EveryHandInMotion;
using test::exampleReady;
using test::HandInMotion;
using test::largestDifference;

// === What must end motion

TEST_P(EveryHandInMotion, HoldsOnAStaleStreamThenGoesOffAndStays) {
  ASSERT_TRUE(hand.start()) << told();
  hand.turnFor(0.3);
  hand.is_streaming = false;
  ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 0.7)) << told();
  EXPECT_EQ(hand.state().hold, HoldCause::kStale);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand.rig().isPowered());
  hand.is_streaming = true;
  hand.offer(0.9);
  hand.turnFor(1);
  EXPECT_EQ(state(), GovernorState::kIdle) << "a returning stream resumes nothing";
}

TEST_P(EveryHandInMotion, AnotherStreamMakesItHold) {
  ASSERT_TRUE(hand.start()) << told();
  hand.turnFor(0.1);
  hand.stream = 2;
  hand.offer(0.8);
  hand.turn();
  EXPECT_EQ(state(), GovernorState::kHolding);
  EXPECT_EQ(hand.state().hold, HoldCause::kStreamChanged);
}

TEST_P(EveryHandInMotion, ASilentDeviceIsAFault) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().emulated().ailments.is_mute = true;
  ASSERT_TRUE(hand.turnUntil(GovernorState::kFault, 2)) << told();
  EXPECT_EQ(wireFault(hand.state()), v1::FAULT_SILENT) << told();
  expectOffForGood();
}

TEST_P(EveryHandInMotion, AnswersThatAlwaysComeLateAreAFault) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().emulated().ailments.delay = milliseconds(30);
  const bool is_fault = hand.turnUntil(GovernorState::kFault, 2);
  // Answers without numbers may be taken for the next question's: those of a bus that is
  // always late by the same time are old, but true. Then nothing may be wrong with the motion.
  if (is_fault) expectOffForGood();
  EXPECT_TRUE(is_fault || largestDifference(hand.state().position, hand.state().target) < 1);
}

TEST_P(EveryHandInMotion, BearsRepeatedAnswersAndGarbage) {
  ASSERT_TRUE(hand.start(0.5)) << told();
  hand.rig().emulated().ailments.repeats = true;
  hand.rig().emulated().ailments.garbage_rate = 0.03;  // a line of text is lost by it
  hand.turnFor(2);
  EXPECT_EQ(state(), GovernorState::kArmed) << told();
}

TEST_P(EveryHandInMotion, AnErrorThatTheDeviceTellsEndsMotion) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().breakDown();
  if (GetParam() == "ability_hand") {
    // It says only that a motor is held back: it holds, then goes off.
    ASSERT_TRUE(hand.turnUntil(GovernorState::kHolding, 2)) << told();
    EXPECT_EQ(hand.state().hold, HoldCause::kMotorLimited);
    return;
  }
  ASSERT_TRUE(hand.turnUntil(GovernorState::kFault, 2)) << told();
  // An Allegro tells no errors: of what is broken nothing is heard.
  const bool is_mute = GetParam() == "allegro";
  EXPECT_EQ(wireFault(hand.state()), is_mute ? v1::FAULT_SILENT : v1::FAULT_HARDWARE) << told();
  expectOffForGood();
  hand.motion().request(Request::kReset);
  hand.turnFor(5);
  EXPECT_EQ(state(), is_mute ? GovernorState::kDisconnected : GovernorState::kFault)
      << "the cause is still there";
  hand.rig().heal();
  hand.motion().request(Request::kReset);
  EXPECT_TRUE(hand.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST_P(EveryHandInMotion, SuspendedTheDevicesOwnWatchdogStopsItAndItStaysOff) {
  ASSERT_TRUE(hand.start(0.9)) << told();
  hand.turnFor(0.2);
  hand.rig().wire().pass(std::chrono::seconds(2));  // as by SIGSTOP
  EXPECT_EQ(hand.rig().isPowered(), !traits().has_watchdog);
  hand.turn();
  hand.turn();
  EXPECT_EQ(state(), GovernorState::kFault) << told();
  EXPECT_EQ(wireFault(hand.state()), v1::FAULT_LATE) << told();
  expectOffForGood();
}

TEST_P(EveryHandInMotion, UnpluggedAndPluggedInAgainItStaysDisarmed) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().wire().unplug();
  hand.turn();
  hand.turn();
  EXPECT_EQ(state(), GovernorState::kFault) << told();
  EXPECT_EQ(wireFault(hand.state()), v1::FAULT_WIRE) << told();
  hand.turnFor(1);
  hand.rig().wire().plug();
  hand.turnFor(3);
  EXPECT_EQ(state(), GovernorState::kFault);
  hand.motion().request(Request::kReset);
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  hand.turnFor(1);
  EXPECT_FALSE(hand.rig().isPowered());
  EXPECT_TRUE(hand.start(0.5)) << told();
}

TEST_P(EveryHandInMotion, LostItIsToldByItsPortAndThatNobodyKnowsOfItsMotors) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().wire().unplug();
  hand.turn();
  hand.turn();
  ASSERT_EQ(state(), GovernorState::kFault) << told();
  const auto tells = [this](const std::string& part) {
    return told().find(part) != std::string::npos;
  };
  EXPECT_TRUE(tells(hand.motion().config().device.port)) << told();
  EXPECT_TRUE(tells("whether its motors are off is not known")) << told();
  EXPECT_TRUE(tells("cut their power")) << told();
  EXPECT_EQ(tells("its own watchdog stops them"), traits().has_watchdog) << told();
  EXPECT_EQ(tells("it has no watchdog"), !traits().has_watchdog) << told();
}

TEST_P(EveryHandInMotion, SilentItIsToldThatNobodyKnowsOfItsMotors) {
  ASSERT_TRUE(hand.start()) << told();
  hand.rig().emulated().ailments.is_mute = true;
  ASSERT_TRUE(hand.turnUntil(GovernorState::kFault, 2)) << told();
  EXPECT_NE(told().find("is not known: cut "), std::string::npos) << told();
  EXPECT_EQ(told().find("watchdog"), std::string::npos) << "it may hear us still: " << told();
}

TEST_P(EveryHandInMotion, PluggedInLateItIsFoundAndStaysOff) {
  hand.rig().wire().unplug();
  hand.turnFor(3);
  EXPECT_EQ(state(), GovernorState::kDisconnected);
  EXPECT_FALSE(hand.state().trouble.view().empty());
  hand.rig().wire().plug();
  EXPECT_TRUE(hand.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand.rig().isPowered());
}

TEST_P(EveryHandInMotion, AnEmergencyStopAtAnyTickBrakesAndSwitchesOff) {
  std::mt19937 random(11);
  for (int run = 0; run < 5; ++run) {
    HandInMotion one(exampleReady(GetParam()));
    ASSERT_TRUE(one.start(0.9)) << describe(one.state());
    const auto wait = static_cast<int>(random() % 120);
    for (int k = 0; k < wait; ++k)
      one.turn();
    one.motion().estop();
    const devices::TimePoint asked = one.now();
    std::vector<double> last = one.state().command;
    while (one.state().is_powered && one.now() - asked < std::chrono::seconds(3)) {
      one.turn();
      EXPECT_EQ(one.state().state, GovernorState::kEStop);
      const config::HandConfig& config = one.motion().config();
      for (std::size_t i = 0; one.state().is_powered && i < last.size(); ++i) {
        const double step = config.governor.limits[i].velocity * config.governor.period_s;
        EXPECT_LE(std::abs(one.state().command[i] - last[i]), step * (1 + 1e-6));
      }
      last = one.state().command;
    }
    EXPECT_LE(one.now() - asked,
              one.motion().config().governor.brake_within + milliseconds(200));
    EXPECT_FALSE(one.rig().isPowered());
    one.offer(0.1);
    one.motion().request(Request::kArm);
    one.turnFor(0.3);
    EXPECT_EQ(one.state().state, GovernorState::kEStop) << "latched";
    one.motion().request(Request::kReset);
    EXPECT_TRUE(one.turnUntil(GovernorState::kIdle)) << describe(one.state());
    EXPECT_FALSE(one.rig().isPowered());
  }
}

TEST_P(EveryHandInMotion, AnEmergencyStopByCutIsTheNextThingTheDeviceHears) {
  config::HandConfig config = exampleReady(GetParam());
  config.governor.stop_mode = safety::StopMode::kCut;
  HandInMotion one(config);
  ASSERT_TRUE(one.start(0.9)) << describe(one.state());
  one.turnFor(0.3);
  const std::vector<double> before = one.angles();
  one.motion().estop();
  one.turn();
  EXPECT_FALSE(one.rig().isPowered());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = 3 * config.governor.period_s * config.motors[i].velocity_rad_s;
    EXPECT_NEAR(one.angles()[i], before[i], way);
  }
  one.turn();  // the device says that it is off
  one.motion().request(Request::kReset);
  EXPECT_TRUE(one.turnUntil(GovernorState::kIdle)) << describe(one.state());
}

TEST_P(EveryHandInMotion, AnEmergencyStopDoesNotWaitUntilMotorsAreOn) {
  ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  hand.rig().emulated().ailments.delay = milliseconds(2);  // so that arming takes its time
  int gave_way = 0;
  for (const int delay_ms : {0, 1, 4, 15, 40, 80}) {
    hand.turn();
    hand.offer(0.5);
    hand.motion().request(Request::kArm);
    hand.stop_asked_at = hand.now() + milliseconds(delay_ms);
    hand.motion().turn();
    if (hand.now() < *hand.stop_asked_at) break;  // it is not that slow
    ++gave_way;
    EXPECT_LE(hand.now() - *hand.stop_asked_at, milliseconds(50)) << delay_ms;
    EXPECT_FALSE(hand.rig().isPowered()) << delay_ms;
    hand.stop_asked_at.reset();
    hand.motion().estop();  // as the motion's thread does before the next turn
    hand.turn();
    EXPECT_EQ(state(), GovernorState::kEStop) << told();
    EXPECT_FALSE(hand.rig().isPowered());
    hand.turn();
    hand.motion().request(Request::kReset);
    ASSERT_TRUE(hand.turnUntil(GovernorState::kIdle)) << told();
  }
  // A hand that comes as a whole, or has one motor, is armed by a few messages.
  const bool is_soon_armed =
      traits().own_motors > 0 || hand.motion().config().motors.size() == 1;
  EXPECT_GE(gave_way, GetParam() == "ability_hand" ? 1 : is_soon_armed ? 3 : 4);
}

}  // namespace
}  // namespace handgraft::bridge
