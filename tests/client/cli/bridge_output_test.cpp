// What `handgraft bridge` says of a hand.
#include "client/cli/commands/bridge_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::client {
namespace {

using testing::HasSubstr;

v1::BridgeStatus statusOf(v1::BridgeState state,
                          v1::MotorPower power,
                          v1::BridgeFault fault = v1::FAULT_NONE) {
  v1::BridgeStatus bridge;
  bridge.bridge_id(1);
  bridge.hand("leap");
  bridge.state(state);
  bridge.power(power);
  bridge.fault(fault);
  return bridge;
}

TEST(BridgeOutput, SaysOfNoDeviceThatIsGoneThatItsMotorsAreOff) {
  for (const v1::BridgeFault fault : {v1::FAULT_WIRE, v1::FAULT_SILENT}) {
    for (const v1::BridgeState state : {v1::BRIDGE_FAULT, v1::BRIDGE_ESTOP}) {
      EXPECT_THAT(statusText({statusOf(state, v1::POWER_UNKNOWN, fault)}),
                  HasSubstr("motors  not known whether they are off: cut their power"));
    }
  }
  EXPECT_THAT(statusText({statusOf(v1::BRIDGE_DISCONNECTED, v1::POWER_UNKNOWN)}),
              HasSubstr("motors  not known whether they are off: there is no device"));
}

TEST(BridgeOutput, SaysWhatADeviceThatIsThereSaysOfItsMotors) {
  EXPECT_THAT(statusText({statusOf(v1::BRIDGE_IDLE, v1::POWER_OFF)}), HasSubstr("motors  off"));
  EXPECT_THAT(statusText({statusOf(v1::BRIDGE_FAULT, v1::POWER_OFF, v1::FAULT_HARDWARE)}),
              HasSubstr("motors  off"));
  EXPECT_THAT(statusText({statusOf(v1::BRIDGE_ARMED, v1::POWER_ON)}),
              HasSubstr("motors  under power"));
}

TEST(BridgeOutput, TellsOnceThatZerosAreNotKnown) {
  v1::BridgeStatus bridge = statusOf(v1::BRIDGE_IDLE, v1::POWER_OFF);
  bridge.reason("motors off; zeros are not known: WHY");
  bridge.last_refusal("ARM refused: zeros are not known: WHY");
  bridge.refusal(v1::REFUSAL_NOT_HOMED);
  EXPECT_EQ(whyNotText(bridge), "ARM refused: zeros are not known: WHY");
  bridge.reason("fault: no answer");
  bridge.last_refusal("ARM refused: fault: reset first");
  bridge.refusal(v1::REFUSAL_FAULT);
  EXPECT_EQ(whyNotText(bridge), "fault: no answer; ARM refused: fault: reset first");
}

}  // namespace
}  // namespace handgraft::client
