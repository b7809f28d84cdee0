#include "hardware/devices/ability_hand_device.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/emulators/ability_hand_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::devices {
namespace {

namespace ah = protocols::ability_hand;
using std::chrono::milliseconds;

class AbilityHandDeviceTest : public ::testing::Test {
 protected:
  AbilityHandDeviceTest() : wire(test::makeVirtualWire(emulator)), state(ah::kMotorCount) {}

  AbilityHandDevice& make(const AbilityHandConfig& config = {}) {
    hand = std::make_unique<AbilityHandDevice>(config, wire->channel(), wire->clock());
    return *hand;
  }

  void cycle() {
    static_cast<void>(hand->read(state));
    static_cast<void>(hand->write(std::vector<double>{0.3, 0.3, 0.3, 0.3, 0.3, -0.3}));
    wire->pass(milliseconds(10));
  }

  test::AbilityHandEmulator emulator;
  std::unique_ptr<test::Wire> wire;
  std::unique_ptr<AbilityHandDevice> hand;
  DeviceState state;
};

TEST_F(AbilityHandDeviceTest, OpeningAndReadingDoNotTakeTheHandOver) {
  make().open();
  for (int i = 0; i < 20; ++i)
    EXPECT_TRUE(hand->read(state));
  EXPECT_FALSE(emulator.is_in_api_mode);
}

TEST_F(AbilityHandDeviceTest, ACycleTakesOneExchange) {
  make().open();
  hand->arm();
  cycle();
  test::takeSent(*wire);
  for (int i = 0; i < 10; ++i)
    cycle();
  EXPECT_EQ(test::takeSent(*wire).size(), 10u);
}

TEST_F(AbilityHandDeviceTest, ReadingAloneKeepsItHolding) {
  make().open();
  hand->arm();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(hand->read(state));
    wire->pass(milliseconds(10));
  }
  EXPECT_TRUE(emulator.is_in_api_mode);
}

TEST_F(AbilityHandDeviceTest, OurOwnSilenceIsAFaultBeforeTheHandGoesItsWay) {
  for (const bool reads : {true, false}) {
    make().open();
    hand->arm();
    cycle();
    wire->pass(milliseconds(150));
    ASSERT_TRUE(emulator.is_in_api_mode);
    if (reads) {
      EXPECT_FALSE(hand->read(state));
    } else {
      EXPECT_FALSE(hand->write(std::vector<double>(6, 0.0)));
    }
    EXPECT_EQ(hand->fault().kind, Fault::Kind::kStarved);
    EXPECT_FALSE(emulator.is_in_api_mode);
  }
}

TEST_F(AbilityHandDeviceTest, DisarmingExitsInsteadOfFallingSilent) {
  make().open();
  hand->arm();
  const int before = emulator.exits;
  EXPECT_TRUE(hand->disarm());
  EXPECT_GT(emulator.exits, before);
  EXPECT_FALSE(emulator.is_in_api_mode);
}

TEST_F(AbilityHandDeviceTest, AMotorHeldBackIsToldAtOnceAndAFaultInTheEnd) {
  make().open();
  hand->arm();
  emulator.limited = 0x21;
  cycle();
  cycle();
  EXPECT_FALSE(hand->fault());
  EXPECT_EQ(state.limited, (std::vector<std::uint8_t>{1, 0, 0, 0, 0, 1}));
  for (int i = 0; i < 40; ++i)
    cycle();
  EXPECT_FALSE(hand->fault()) << "before its patience of 500 ms";
  for (int i = 0; i < 12; ++i)
    cycle();
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kHot);
  EXPECT_EQ(hand->fault().motor, 0);
  EXPECT_EQ(hand->fault().code, 0x21u);
}

TEST_F(AbilityHandDeviceTest, BeingHeldBackNowAndThenIsNoFault) {
  make().open();
  hand->arm();
  for (int i = 0; i < 300; ++i) {
    emulator.limited = i % 30 == 0 ? 0 : 0x01;
    cycle();
  }
  EXPECT_FALSE(hand->fault());
}

TEST_F(AbilityHandDeviceTest, OtherRepliesTellOtherThings) {
  emulator.touch.fill(1000);
  AbilityHandConfig config;
  config.reply = ah::Reply::kTouchCurrent;
  make(config).open();
  ASSERT_TRUE(hand->read(state));
  EXPECT_TRUE(std::isnan(state.velocity[0]));
  EXPECT_EQ(state.current[0], 0.0);
  EXPECT_EQ(hand->touch()[29], ah::touchForce(1000));
  EXPECT_NEAR(state.position[0], 2000 * ah::kRadPerCount, 1e-12);

  config.reply = ah::Reply::kTouchVelocity;
  make(config).open();
  ASSERT_TRUE(hand->read(state));
  EXPECT_TRUE(std::isnan(state.current[0]));
  EXPECT_EQ(state.velocity[0], 0.0);

  make().open();
  ASSERT_TRUE(hand->read(state));
  EXPECT_EQ(hand->touch().size(), 0u);
}

TEST_F(AbilityHandDeviceTest, AReplyOfAnotherVariantIsNoAnswer) {
  make().open();
  emulator.ailments.delay = milliseconds(2);
  ah::State other;
  other.reply = ah::Reply::kTouchCurrent;
  other.header = 0x10;
  other.position.fill(12345);
  protocols::ByteBuffer packet;
  ah::encodeState(other, packet);
  emulator.inject(test::vectorOf(packet.bytes()), wire->clock()() + milliseconds(1));
  ASSERT_TRUE(hand->read(state));
  EXPECT_NEAR(state.position[0], 2000 * ah::kRadPerCount, 1e-12);
  EXPECT_EQ(hand->counters().stray, 1u);
}

TEST_F(AbilityHandDeviceTest, AnotherAddressDoesNotAnswer) {
  AbilityHandConfig config;
  config.address = 0x51;
  EXPECT_THROW(make(config).open(), DeviceError);
}

TEST_F(AbilityHandDeviceTest, ConfigurationsAreChecked) {
  AbilityHandConfig config;
  config.upper[2] = 3.0;  // beyond 150 degrees
  EXPECT_THROW(make(config), InvalidInput);
  config = {};
  config.address = 0;
  EXPECT_THROW(make(config), InvalidInput);
  config = {};
  config.longest_gap = milliseconds(300);
  EXPECT_THROW(make(config), InvalidInput);
  config = {};
  config.reply_timeout = milliseconds(0);
  EXPECT_THROW(make(config), InvalidInput);
}

}  // namespace
}  // namespace handgraft::devices
