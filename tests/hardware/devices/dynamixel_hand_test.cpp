#include "hardware/devices/dynamixel_hand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/emulators/dynamixel_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::devices {
namespace {

namespace dxl = protocols::dynamixel;
using std::chrono::milliseconds;

constexpr MotorScale kScale{dxl::kRadPerCount, 2048.0, 1, -1.0, 1.0};

DynamixelConfig twoMotors() {
  DynamixelConfig config;
  config.motors = {{3, kScale}, {1, kScale}};
  return config;
}

class DynamixelHandTest : public ::testing::Test {
 protected:
  DynamixelHandTest() : emulator({3, 1}), wire(test::makeVirtualWire(emulator)), state(2) {}

  /// A driver of `config`, in place of the one before.
  DynamixelHand& make(const DynamixelConfig& config = twoMotors()) {
    hand = std::make_unique<DynamixelHand>(config, wire->channel(), wire->clock());
    return *hand;
  }

  /// What was written to EEPROM since this was last asked.
  int eepromWrites() {
    int count = 0;
    for (const test::ByteVector& message : test::takeSent(*wire)) {
      protocols::StreamReader<dxl::Framing> reader;
      reader.feed(message, [&](protocols::Bytes frame) {
        const dxl::Packet packet = dxl::packetOf(frame);
        const auto instruction = static_cast<dxl::Instruction>(packet.instruction);
        const bool is_write = instruction == dxl::Instruction::kWrite ||
                              instruction == dxl::Instruction::kSyncWrite;
        if (is_write && protocols::numberAt<std::uint16_t>(packet.parameters, 0) < 64) ++count;
      });
    }
    return count;
  }

  std::string openError(const DynamixelConfig& config = twoMotors()) {
    try {
      make(config).open();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }

  test::DynamixelEmulator emulator;
  std::unique_ptr<test::Wire> wire;
  std::unique_ptr<DynamixelHand> hand;
  DeviceState state;
};

TEST_F(DynamixelHandTest, OpeningSetsWhatSafetyRestsOn) {
  for (const std::uint8_t id : {std::uint8_t{3}, std::uint8_t{1}}) {
    emulator.set(id, "torque_enable", 1);
    emulator.set(id, "drive_mode", 0x0D);
    emulator.set(id, "startup_configuration", 3);
    emulator.set(id, "shutdown", 0x01);
    emulator.set(id, "status_return_level", 0);
    emulator.set(id, "profile_velocity", 77);
  }
  make().open();
  for (const std::uint8_t id : {std::uint8_t{3}, std::uint8_t{1}}) {
    EXPECT_EQ(emulator.get(id, "torque_enable"), 0);
    EXPECT_EQ(emulator.get(id, "drive_mode"), 0);
    EXPECT_EQ(emulator.get(id, "operating_mode"), 5);
    EXPECT_EQ(emulator.get(id, "startup_configuration"), 0);
    EXPECT_EQ(emulator.get(id, "shutdown"), 0x35) << "its own bit kept, the model's added";
    EXPECT_EQ(emulator.get(id, "current_limit"), 350);
    EXPECT_EQ(emulator.get(id, "return_delay"), 0);
    EXPECT_EQ(emulator.get(id, "profile_velocity"), 0);
  }
}

TEST_F(DynamixelHandTest, WritesEepromOnlyWhereItDiffers) {
  make().open();
  EXPECT_GT(eepromWrites(), 0);
  make().open();
  EXPECT_EQ(eepromWrites(), 0);
}

TEST_F(DynamixelHandTest, ArmingSetsWatchdogAndCurrent) {
  DynamixelConfig config = twoMotors();
  config.watchdog = milliseconds(90);
  config.motors[1].current_limit_milliamp = 123;
  make(config).open();
  hand->arm();
  EXPECT_EQ(emulator.get(3, "bus_watchdog"), 5) << "rounded up to 100 ms";
  EXPECT_EQ(emulator.get(3, "goal_current"), 350);
  EXPECT_EQ(emulator.get(1, "goal_current"), 123);
  EXPECT_TRUE(hand->disarm());
  EXPECT_EQ(emulator.get(3, "bus_watchdog"), 0);
}

TEST_F(DynamixelHandTest, WritesGainsThatItIsTold) {
  DynamixelConfig config = twoMotors();
  config.motors[0].gains = DynamixelGains{600, 7, 200};
  make(config).open();
  EXPECT_EQ(emulator.get(3, "position_p_gain"), 600);
  EXPECT_EQ(emulator.get(3, "position_i_gain"), 7);
  EXPECT_EQ(emulator.get(3, "position_d_gain"), 200);
  EXPECT_EQ(emulator.get(1, "position_p_gain"), 1100) << "its own";
}

TEST_F(DynamixelHandTest, TellsTemperatureAndCurrent) {
  make().open();
  emulator.set(1, "temperature", 61);
  emulator.set(1, "present_current", -50);
  ASSERT_TRUE(hand->read(state));
  EXPECT_EQ(state.temperature[1], 61.0);
  EXPECT_DOUBLE_EQ(state.current[1], -0.05);
}

TEST_F(DynamixelHandTest, AMotorThatSwitchedOffIsAFault) {
  make().open();
  hand->arm();
  emulator.set(1, "torque_enable", 0);
  EXPECT_FALSE(hand->read(state));
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kPowerLost);
  EXPECT_EQ(hand->fault().motor, 1);
  EXPECT_EQ(emulator.get(3, "torque_enable"), 0) << "the others go off, too";
}

TEST_F(DynamixelHandTest, OneSilentMotorIsAFaultOfThatMotor) {
  make().open();
  hand->arm();
  emulator.motor(1).is_unplugged = true;
  int good = 0;
  while (hand->read(state))
    ++good;
  EXPECT_EQ(good, 3);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kSilent);
  EXPECT_EQ(hand->fault().motor, 1);
  EXPECT_EQ(emulator.get(3, "torque_enable"), 0);
  EXPECT_EQ(hand->counters().missed, 4u);
}

TEST_F(DynamixelHandTest, OpeningEndsAWatchdogThatFiredBefore) {
  emulator.set(3, "torque_enable", 1);
  emulator.set(3, "bus_watchdog", 0xFF);
  make().open();
  EXPECT_EQ(emulator.get(3, "bus_watchdog"), 0);
  hand->arm();
  EXPECT_TRUE(hand->read(state));
}

TEST_F(DynamixelHandTest, GoalsAfterAWatchdogAreNotEvenTaken) {
  make().open();
  hand->arm();
  wire->pass(milliseconds(200));
  EXPECT_TRUE(hand->write(std::vector<double>{0.5, 0.5})) << "nobody has told yet";
  EXPECT_EQ(emulator.motor(3).refused_goals, 1);
  EXPECT_FALSE(hand->read(state));
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kWatchdog);
}

TEST_F(DynamixelHandTest, AnswersOfOthersChangeNothing) {
  make().open();
  // Between question and answer come: another id, an unknown id, a wrong length, an echo.
  emulator.ailments.delay = milliseconds(2);
  const test::ByteVector block(14, 0x11);
  const test::ByteVector few(3, 0x11);
  const TimePoint due = wire->clock()() + milliseconds(1);
  for (const auto& status : {dxl::Status{99, false, dxl::Error::kNone, block},
                             dxl::Status{2, true, dxl::Error::kNone, block},
                             dxl::Status{3, false, dxl::Error::kNone, few}}) {
    protocols::ByteBuffer packet;
    dxl::encodeStatus(status, packet);
    emulator.inject(test::vectorOf(packet.bytes()), due);
  }
  protocols::ByteBuffer echo;
  dxl::encodeSyncRead(208, 14, test::ByteVector{3, 1}, echo);
  emulator.inject(test::vectorOf(echo.bytes()), due);
  const std::uint64_t before = hand->counters().stray;
  ASSERT_TRUE(hand->read(state)) << describe(hand->fault());
  EXPECT_EQ(state.position, (std::vector<double>{0.0, 0.0}));
  EXPECT_EQ(hand->counters().stray - before, 4u);
}

TEST_F(DynamixelHandTest, LateAnswersAreForgotten) {
  make().open();
  hand->arm();
  ASSERT_TRUE(hand->read(state));
  emulator.ailments.delay = milliseconds(7);  // after the patience of 5 ms, before the next
  emulator.set(3, "temperature", 44);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(hand->read(state));
    wire->pass(milliseconds(10));
  }
  EXPECT_NE(state.temperature[0], 44.0);
  EXPECT_FALSE(hand->read(state));
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kSilent);
}

TEST_F(DynamixelHandTest, RestartsMotorsWithAHardwareErrorAlone) {
  make().open();
  hand->arm();
  emulator.set(3, "led", 1);  // RAM: lost by a restart
  emulator.set(1, "led", 1);
  emulator.fail(1, dxl::kOverheating);
  EXPECT_FALSE(hand->read(state));
  EXPECT_EQ(hand->fault().code, dxl::kOverheating);
  hand->reset();
  EXPECT_EQ(emulator.get(1, "led"), 0);
  EXPECT_EQ(emulator.get(3, "led"), 1);
  hand->arm();
  EXPECT_TRUE(hand->read(state));
}

TEST_F(DynamixelHandTest, RefusesMotorsItDoesNotKnow) {
  emulator.set(1, "model_number", 4242);
  EXPECT_THAT(openError(), ::testing::HasSubstr("motor 1: model 4242"));
  emulator.set(1, "model_number", 1200);
  DynamixelConfig config = twoMotors();
  config.motors[1].current_limit_milliamp = 2000;
  EXPECT_THAT(openError(config), ::testing::HasSubstr("at most 1750 mA"));
}

// XM motors measure current in steps of 2.69 mA and keep their indirect data elsewhere.
TEST_F(DynamixelHandTest, DrivesTheOtherModelsInTheirOwnUnits) {
  DynamixelConfig config = twoMotors();
  for (DynamixelMotor& motor : config.motors) {
    emulator.set(motor.id, "model_number", 1020);
    motor.current_limit_milliamp = 500;
    motor.velocity_limit_rad_s = 3;
  }
  make(config).open();
  for (const DynamixelMotor& motor : config.motors) {
    EXPECT_EQ(emulator.get(motor.id, "current_limit"), 185) << "500 mA, rounded down";
    EXPECT_EQ(emulator.get(motor.id, "goal_current"), 185);
    EXPECT_EQ(emulator.get(motor.id, "profile_velocity"), 126) << "3 rad/s, rounded up";
    emulator.set(motor.id, "present_current", 100);
  }
  ASSERT_TRUE(hand->read(state));
  EXPECT_NEAR(std::abs(state.current[0]), 0.269, 1e-9);
}

TEST_F(DynamixelHandTest, RefusesMotorsThatCannotLimitTheirCurrentAndMixedOnes) {
  emulator.set(1, "model_number", 1060);
  EXPECT_THAT(openError(), ::testing::HasSubstr("XL430-W250 does not limit its current"));
  emulator.set(1, "model_number", 1020);
  EXPECT_THAT(openError(), ::testing::HasSubstr("cannot be read together"));
}

TEST_F(DynamixelHandTest, AHiccupWithoutPowerIsNoFaultButLongSilenceIs) {
  make().open();
  emulator.ailments.is_mute = true;
  for (int i = 0; i < 8; ++i) {
    static_cast<void>(hand->read(state));
    wire->pass(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(hand->fault());
  for (int i = 0; i < 300 && !hand->fault(); ++i) {
    static_cast<void>(hand->read(state));
    wire->pass(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kSilent);
}

TEST_F(DynamixelHandTest, SaysErrorsInWords) {
  EXPECT_EQ(make().meaningOf(0x20), "overload");
  EXPECT_EQ(hand->meaningOf(0x24), "overheating, overload");
  EXPECT_EQ(hand->meaningOf(0x40), "0x40");
}

TEST_F(DynamixelHandTest, SaysWhichMotorIsMissing) {
  emulator.motor(1).is_unplugged = true;
  EXPECT_EQ(openError(), "Dynamixel motor 1: no answer");
}

// Found by tests/fuzz/wire_fuzz: the model's number was read from an answer without data.
TEST_F(DynamixelHandTest, AnErrorInsteadOfAModelIsNoAnswer) {
  emulator.ailments.delay = milliseconds(2);
  protocols::ByteBuffer error;
  dxl::encodeStatus({3, false, dxl::Error::kResultFail, {}}, error);
  emulator.inject(test::vectorOf(error.bytes()), wire->clock()() + milliseconds(1));
  EXPECT_EQ(openError(), "Dynamixel motor 3: no answer");
}

TEST_F(DynamixelHandTest, ConfigurationsAreChecked) {
  const auto refuses = [&](const DynamixelConfig& config, const char* what) {
    try {
      make(config);
      ADD_FAILURE() << what;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(what));
    }
  };
  refuses({}, "without motors");
  DynamixelConfig config = twoMotors();
  config.motors[1].id = 3;
  refuses(config, "id 3 is there twice");
  config = twoMotors();
  config.motors[0].id = 253;
  refuses(config, "id 253 is outside 0 to 252");
  config = twoMotors();
  config.motors[0].current_limit_milliamp = 0;
  refuses(config, "current limit 0 mA");
  config = twoMotors();
  config.watchdog = milliseconds(0);
  refuses(config, "watchdog of 0 ms");
  config.watchdog = milliseconds(2541);
  refuses(config, "watchdog of 2541 ms");
  config = twoMotors();
  config.motors[0].scale.upper = 2000.0;
  refuses(config, "outside -1048575 to 1048575");
  config = twoMotors();
  config.return_delay_us = 600;
  refuses(config, "return delay of 600 us");
}

}  // namespace
}  // namespace handgraft::devices
