#include "hardware/bridge/telemetry.h"

#include <gtest/gtest.h>

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using devices::Fault;
using safety::FaultCause;
using safety::GovernorState;
using std::chrono::nanoseconds;

MotionState measured() {
  MotionState state(2);
  state.state = GovernorState::kIdle;
  state.is_connected = true;
  state.position = {0.5, -1.25};
  state.velocity = {0.0, 2.0};
  return state;
}

const std::vector<std::string> joint_names{"a", "b"};

TEST(Telemetry, TellsWhatIsMeasuredAndWhatWasSentUnderPowerAlone) {
  MotionState state = measured();
  state.command = {0.25, 0.75};
  const v1::JointState idle = jointState({}, joint_names, state, 7, nanoseconds(5));
  EXPECT_EQ(idle.names(), joint_names);
  EXPECT_EQ(idle.position(), state.position);
  EXPECT_TRUE(idle.command().empty()) << "nothing was sent";
  EXPECT_TRUE(idle.target().empty()) << "no pose yet";
  state.is_powered = true;
  state.stream = 1;
  const v1::JointState moving = jointState({}, joint_names, state, 8, nanoseconds(5));
  EXPECT_EQ(moving.command(), state.command);
  EXPECT_EQ(moving.target(), state.target);
  EXPECT_EQ(moving.sequence_number(), 8);
}

TEST(Telemetry, AHandThatIsNotThereHasNoPose) {
  MotionState state = measured();
  state.is_connected = false;
  const v1::JointState message = jointState({}, joint_names, state, 1, nanoseconds(5));
  EXPECT_TRUE(message.names().empty());
  EXPECT_TRUE(message.position().empty());
}

TEST(Telemetry, TellsWhichJointsSlide) {
  BridgeIdentity identity;
  identity.sliding = {"b"};
  const v1::JointState told = jointState(identity, joint_names, measured(), 1, nanoseconds(5));
  EXPECT_EQ(told.sliding(), identity.sliding);
}

TEST(Telemetry, OfADeviceThatIsGoneOrSilentNobodyKnowsWhetherItsMotorsAreOff) {
  BridgeIdentity identity;
  identity.hand = "leap";
  const auto told = [&](GovernorState state, FaultCause fault, bool is_powered = false) {
    MotionState motion = measured();
    motion.state = state;
    motion.fault = fault;
    motion.is_powered = is_powered;
    return bridgeStatus(identity, motion, nanoseconds(5)).power();
  };
  for (const FaultCause fault : {FaultCause::kDeviceLost, FaultCause::kDeviceSilent}) {
    for (const GovernorState state :
         {GovernorState::kFault, GovernorState::kEStop, GovernorState::kDisconnected})
      EXPECT_EQ(told(state, fault), v1::POWER_UNKNOWN);
  }
  EXPECT_EQ(told(GovernorState::kDisconnected, FaultCause::kNone), v1::POWER_UNKNOWN);
  EXPECT_EQ(told(GovernorState::kIdle, FaultCause::kNone), v1::POWER_OFF);
  EXPECT_EQ(told(GovernorState::kEStop, FaultCause::kStaysOn), v1::POWER_OFF);
  EXPECT_EQ(told(GovernorState::kArmed, FaultCause::kNone, true), v1::POWER_ON);
  identity.hand = "";  // and no motors yet
  EXPECT_EQ(told(GovernorState::kDisconnected, FaultCause::kNone), v1::POWER_OFF);
}

TEST(Telemetry, TellsThatZerosAreSought) {
  MotionState state = measured();
  EXPECT_FALSE(bridgeStatus({}, state, nanoseconds(5)).homing());
  state.is_homing = true;
  EXPECT_TRUE(bridgeStatus({}, state, nanoseconds(5)).homing());
}

TEST(Telemetry, RosLeavesUnknownVelocitiesOut) {
  MotionState state = measured();
  EXPECT_EQ(rosJointState("hand", joint_names, state, nanoseconds(0)).velocity(),
            state.velocity);
  state.velocity[1] = test::kNaN;
  EXPECT_TRUE(rosJointState("hand", joint_names, state, nanoseconds(0)).velocity().empty());
}

TEST(Telemetry, RosStampsAreWholeSecondsAndPositiveNanoseconds) {
  const auto stamp_of = [](std::int64_t ns) {
    return rosJointState("hand", joint_names, measured(), nanoseconds(ns)).header().stamp();
  };
  EXPECT_EQ(stamp_of(1'700'000'000'123'456'789).sec(), 1'700'000'000);
  EXPECT_EQ(stamp_of(1'700'000'000'123'456'789).nanosec(), 123'456'789U);
  EXPECT_EQ(stamp_of(-1).sec(), -1);
  EXPECT_EQ(stamp_of(-1).nanosec(), 999'999'999U);
}

TEST(Telemetry, EveryFaultOfADeviceIsToldAsItself) {
  MotionState state = measured();
  state.state = GovernorState::kFault;
  state.fault = FaultCause::kDevice;
  const std::pair<Fault::Kind, v1::BridgeFault> kinds[] = {
      {Fault::Kind::kWire, v1::FAULT_WIRE},
      {Fault::Kind::kSilent, v1::FAULT_SILENT},
      {Fault::Kind::kHardware, v1::FAULT_HARDWARE},
      {Fault::Kind::kHot, v1::FAULT_HOT},
      {Fault::Kind::kWatchdog, v1::FAULT_WATCHDOG},
      {Fault::Kind::kPowerLost, v1::FAULT_POWER_LOST},
      {Fault::Kind::kStarved, v1::FAULT_STARVED},
      {Fault::Kind::kBadTarget, v1::FAULT_BAD_TARGET}};
  for (const auto& [kind, wire] : kinds) {
    state.device_fault = {kind, 1, 0};
    EXPECT_EQ(wireFault(state), wire);
    EXPECT_NE(bridgeStatus({}, state, nanoseconds(0)).reason().find("motor 1"),
              std::string::npos);
  }
  state.guard_failed = true;
  EXPECT_EQ(wireFault(state), v1::FAULT_GUARD);
}

TEST(Telemetry, NoFaultOfTheGovernorIsToldAsNone) {
  MotionState state = measured();
  EXPECT_EQ(wireFault(state), v1::FAULT_NONE);
  for (int i = 1; i < static_cast<int>(FaultCause::kCount); ++i) {
    state.fault = static_cast<FaultCause>(i);
    state.device_fault = {Fault::Kind::kSilent, -1, 0};
    EXPECT_NE(wireFault(state), v1::FAULT_NONE) << toString(state.fault);
  }
}

TEST(Telemetry, StatusTellsAgesTheLargestResidualAndLatenesses) {
  MotionState state = measured();
  state.residual_rad = 0.4;
  state.worst_lateness = std::chrono::microseconds(1500);
  BridgeIdentity identity;
  identity.bridge_id = 3;
  identity.hand = "leap";
  const v1::BridgeStatus before = bridgeStatus(identity, state, nanoseconds(0));
  EXPECT_EQ(before.command_age_s(), -1);
  EXPECT_EQ(before.stream_age_s(), -1);
  EXPECT_EQ(before.temperature_c(), -1);
  EXPECT_DOUBLE_EQ(before.residual_rad(), 0.4);
  EXPECT_DOUBLE_EQ(before.worst_lateness_s(), 1.5e-3);
  EXPECT_EQ(before.hand(), "leap");
  state.command_age = std::chrono::milliseconds(250);
  EXPECT_DOUBLE_EQ(bridgeStatus(identity, state, nanoseconds(0)).command_age_s(), 0.25);
}

}  // namespace
}  // namespace handgraft::bridge
