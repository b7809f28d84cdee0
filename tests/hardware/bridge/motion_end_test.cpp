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
  // An Allegro tells no errors: of what is broken nothing is heard.
  const bool is_mute = GetParam() == "allegro";
  EXPECT_EQ(wireFault(hand_.state()), is_mute ? v1::FAULT_SILENT : v1::FAULT_HARDWARE)
      << told();
  expectOffForGood();
  hand_.motion().request(Request::kReset);
  hand_.turnFor(5);
  EXPECT_EQ(state(), is_mute ? GovernorState::kDisconnected : GovernorState::kFault)
      << "the cause is still there";
  hand_.rig().heal();
  hand_.motion().request(Request::kReset);
  EXPECT_TRUE(hand_.turnUntil(GovernorState::kIdle, 5)) << told();
  EXPECT_FALSE(hand_.rig().isPowered());
}

TEST_P(EveryHandInMotion, SuspendedTheDevicesOwnWatchdogStopsItAndItStaysOff) {
  ASSERT_TRUE(hand_.start(0.9)) << told();
  hand_.turnFor(0.2);
  hand_.rig().wire().pass(std::chrono::seconds(2));  // as by SIGSTOP
  EXPECT_EQ(hand_.rig().isPowered(), !traits().has_watchdog);
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
  // A hand that comes as a whole is armed by a few messages.
  EXPECT_GE(gave_way, GetParam() == "ability_hand" ? 1 : traits().own_motors > 0 ? 3 : 4);
}

}  // namespace
}  // namespace handgraft::bridge
