#include "hardware/protocols/odrive_can.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/hardware/protocols/hex.h"

namespace handgraft::protocols::odrive {
namespace {

using test::fromHex;
using test::toHex;

TEST(ODriveCan, IdsHoldAxisAndCommand) {
  EXPECT_EQ(idOf(1, Command::kSetInputPosition), 0x2Cu);  // the documentation's example
  EXPECT_EQ(idOf(0, Command::kHeartbeat), 0x01u);
  EXPECT_EQ(idOf(63, Command::kClearErrors), 0x7F8u);
  EXPECT_THROW(idOf(64, Command::kHeartbeat), BrokenContract);
  EXPECT_THROW(idOf(-1, Command::kHeartbeat), BrokenContract);
  for (int node = 0; node <= kHighestNode; ++node) {
    const auto address = addressOf(estop(node));
    ASSERT_TRUE(address);
    EXPECT_EQ(address->node, node);
    EXPECT_EQ(address->command, 0x02);
  }
  CanFrame extended = estop(1);
  extended.is_extended = true;
  EXPECT_FALSE(addressOf(extended));
}

TEST(ODriveCan, NumbersAreIeee754LowByteFirst) {
  // 1.0 is 0x3F800000, -2.0 is 0xC0000000.
  EXPECT_EQ(toHex(setLimits(1, 1.0f, -2.0f).bytes()), "0000803f000000c0");
  EXPECT_EQ(toHex(setInputPosition(1, 1.0f, 0.258, -0.002).bytes()), "0000803f0201feff");
  EXPECT_EQ(toHex(setInputVelocity(1, -2.0f, 1.0f).bytes()), "000000c00000803f");
  EXPECT_EQ(toHex(setAxisState(1, AxisState::kClosedLoop).bytes()), "0800000000000000");
  EXPECT_TRUE(estop(1).bytes().empty());
}

TEST(ODriveCan, FeedForwardIsRoundedAndClamped) {
  const auto second = [](double velocity) {
    return inputPositionOf(setInputPosition(1, 0.0f, velocity))->velocity_rev_s;
  };
  EXPECT_NEAR(second(0.5), 0.5, 1e-12);
  EXPECT_NEAR(second(0.0016), 0.002, 1e-12);
  EXPECT_NEAR(second(1e6), 32.767, 1e-12);
  EXPECT_NEAR(second(-1e6), -32.767, 1e-12);
}

TEST(ODriveCan, NothingThatIsNoNumberIsSent) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(setInputPosition(1, nan), BrokenContract);
  EXPECT_THROW(setInputPosition(1, 0.0f, std::nan("")), BrokenContract);
  EXPECT_THROW(setLimits(1, 1.0f, nan), BrokenContract);
  EXPECT_THROW(setInputVelocity(1, nan, 0.0f), BrokenContract);
  EXPECT_THROW(setInputTorque(1, std::numeric_limits<float>::infinity()), BrokenContract);
}

TEST(ODriveCan, CommandsAreReadBack) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(-30.0f, 30.0f);
  for (int i = 0; i < 200; ++i) {
    const int node = static_cast<int>(random() % 64);
    const float position = number(random), velocity = number(random);
    const auto input = inputPositionOf(setInputPosition(node, position, velocity, 0.1));
    ASSERT_TRUE(input);
    EXPECT_EQ(input->position_rev, position);
    EXPECT_NEAR(input->velocity_rev_s, velocity, 0.0005 + 1e-9);
    EXPECT_NEAR(input->torque, 0.1, 1e-12);
    EXPECT_EQ(limitsOf(setLimits(node, position, velocity)), (FloatPair{position, velocity}));
  }
  EXPECT_EQ(axisStateOf(setAxisState(3, AxisState::kIdle)), AxisState::kIdle);
  const auto mode =
      controllerModeOf(setControllerMode(3, ControlMode::kPosition, InputMode::kTrapezoidal));
  ASSERT_TRUE(mode);
  EXPECT_EQ(mode->control, ControlMode::kPosition);
  EXPECT_EQ(mode->input, InputMode::kTrapezoidal);
}

TEST(ODriveCan, HeartbeatsOfBothFirmwaresAreReadBack) {
  for (unsigned bits = 0; bits < 16; ++bits) {
    Heartbeat beat;
    beat.error = kWatchdogExpired;
    beat.state = AxisState::kIdle;
    beat.is_trajectory_done = (bits & 1) != 0;
    beat.procedure_result = 3;
    EXPECT_EQ(heartbeatOf(makeHeartbeat(5, beat), Firmware::k06), beat);
    beat.procedure_result = 0;
    beat.motor_error = (bits & 2) != 0;
    beat.encoder_error = (bits & 4) != 0;
    beat.controller_error = (bits & 8) != 0;
    EXPECT_EQ(heartbeatOf(makeHeartbeat(5, beat, Firmware::k05), Firmware::k05), beat);
  }
}

TEST(ODriveCan, AHeartbeatIsFaultyByAnyOfItsErrors) {
  EXPECT_FALSE(Heartbeat{}.isFaulty());
  Heartbeat beat;
  beat.error = 1;
  EXPECT_TRUE(beat.isFaulty());
  beat = {};
  beat.encoder_error = true;
  EXPECT_TRUE(beat.isFaulty());
}

TEST(ODriveCan, WrongCommandsLengthsAndRemoteFramesSayNothing) {
  CanFrame beat = makeHeartbeat(1, {});
  EXPECT_TRUE(heartbeatOf(beat));
  EXPECT_FALSE(encoderEstimatesOf(beat));
  EXPECT_FALSE(iqOf(beat));
  beat.size = 7;
  EXPECT_FALSE(heartbeatOf(beat));
  EXPECT_FALSE(encoderEstimatesOf(askFor(1, Command::kGetEncoderEstimates)));
}

TEST(ODriveCan, AskingIsARemoteFrameOfTheSameId) {
  const CanFrame ask = askFor(1, Command::kGetEncoderEstimates);
  EXPECT_TRUE(ask.is_remote);
  EXPECT_EQ(ask.id, makeFloatPair(1, Command::kGetEncoderEstimates, {}).id);
  EXPECT_TRUE(ask.bytes().empty());
}

}  // namespace
}  // namespace handgraft::protocols::odrive
