#include "hardware/devices/odrive_hand.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/devices/slcan_channel.h"

#include "tests/hardware/emulators/odrive_emulator.h"
#include "tests/hardware/emulators/wire.h"

namespace handgraft::devices {
namespace {

namespace odrive = protocols::odrive;
using std::chrono::milliseconds;
using std::chrono::seconds;

ODriveConfig twoAxes() {
  const MotorScale scale{2.0 * std::numbers::pi, 0.0, 1, -3.0, 6.0};
  ODriveConfig config;
  config.axes = {{0, scale}, {5, scale}};
  return config;
}

class ODriveHandTest : public ::testing::Test {
 protected:
  ODriveHandTest()
      : bus({0, 5, 20}, odrive::Firmware::k06),
        adapter(bus),
        wire(test::makeVirtualWire(adapter)),
        can(wire->channel(), 500000, wire->clock()),
        state(2) {}

  ODriveHand& make(const ODriveConfig& config = twoAxes()) {
    hand = std::make_unique<ODriveHand>(config, can, wire->clock());
    return *hand;
  }

  void cycle(int count = 1) {
    for (int i = 0; i < count; ++i) {
      static_cast<void>(hand->read(state));
      static_cast<void>(hand->write(std::vector<double>{1.0, 1.0}));
      wire->pass(milliseconds(10));
    }
  }

  test::ODriveEmulator bus;
  test::SlcanEmulator adapter;
  std::unique_ptr<test::Wire> wire;
  SlcanChannel can;
  std::unique_ptr<ODriveHand> hand;
  DeviceState state;
};

TEST_F(ODriveHandTest, ArmingSetsLimitsOnItsAxesAlone) {
  ODriveConfig config = twoAxes();
  config.axes[1].velocity_limit_rev_s = 3.5;
  make(config).open();
  hand->arm();
  EXPECT_EQ(bus.axis(5).servo.speed, 3.5);
  EXPECT_EQ(bus.axis(5).state, odrive::AxisState::kClosedLoop);
  EXPECT_EQ(bus.axis(20).state, odrive::AxisState::kIdle);
}

TEST_F(ODriveHandTest, ArmingNeverClearsErrors) {
  test::ODriveEmulator::fail(bus.axis(5), 0x100);
  make().open();
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kHardware);
  EXPECT_EQ(hand->fault().motor, 1);
  EXPECT_EQ(hand->fault().code, 0x100u);
  EXPECT_THROW(hand->arm(), DeviceError);
  EXPECT_EQ(bus.axis(5).error & 0x100u, 0x100u);
  hand->reset();
  EXPECT_EQ(bus.axis(5).error, 0u);
  hand->arm();
}

TEST_F(ODriveHandTest, MissingHeartbeatsAreSilenceAlthoughEstimatesCome) {
  make().open();
  hand->arm();
  bus.heartbeat_period = seconds(100);
  cycle(60);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kSilent);
}

TEST_F(ODriveHandTest, MissingEstimatesAreSilenceAlthoughHeartbeatsCome) {
  make().open();
  hand->arm();
  bus.axis(5).servo.position = std::nan("");  // which is not taken for a position
  cycle(6);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kSilent);
  EXPECT_EQ(hand->fault().motor, 1);
}

TEST_F(ODriveHandTest, AnAxisThatIsNoLongerInItsLoopHasLostItsPower) {
  make().open();
  hand->arm();
  bus.axis(0).state = odrive::AxisState::kIdle;
  cycle(12);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kPowerLost);
  EXPECT_EQ(hand->fault().motor, 0);
  EXPECT_EQ(bus.axis(5).error, odrive::kEstopRequested) << "the others are stopped, too";
}

TEST_F(ODriveHandTest, AnotherOnesEmergencyStopIsAFault) {
  make().open();
  hand->arm();
  test::ODriveEmulator::fail(bus.axis(0), odrive::kEstopRequested);
  cycle(12);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kHardware);
  EXPECT_EQ(hand->fault().code, odrive::kEstopRequested);
}

TEST_F(ODriveHandTest, AfterItsOwnStopAnArmingNeedsAReset) {
  make().open();
  hand->arm();
  hand->stop();
  EXPECT_EQ(bus.axis(0).error, odrive::kEstopRequested);
  cycle(12);
  EXPECT_THROW(hand->arm(), DeviceError);
  hand->reset();
  hand->arm();
  cycle(5);
  EXPECT_FALSE(hand->fault());
}

TEST_F(ODriveHandTest, ArmingGivesUpOnAnAxisThatDoesNotObey) {
  make().open();
  bus.heartbeat_period = seconds(100);  // it cannot tell that it obeyed
  wire->pass(milliseconds(150));        // the last one was on its way
  EXPECT_THROW(hand->arm(), DeviceError);
  EXPECT_FALSE(hand->isArmed());
  EXPECT_NE(bus.axis(0).state, odrive::AxisState::kClosedLoop);
}

TEST_F(ODriveHandTest, TheFirstArmingProvesTheWatchdogsBySilence) {
  make().open();
  const TimePoint start = wire->clock()();
  hand->arm();
  EXPECT_GT(wire->clock()() - start, milliseconds(200)) << "as long as a watchdog takes";
  EXPECT_EQ(bus.axis(5).error, 0u) << "what was provoked is cleared";
  EXPECT_EQ(bus.axis(5).state, odrive::AxisState::kClosedLoop);
  cycle(5);
  EXPECT_FALSE(hand->fault());
  hand->disarm();
  const TimePoint again = wire->clock()();
  hand->arm();
  EXPECT_LT(wire->clock()() - again, milliseconds(200)) << "once after each open";
}

TEST_F(ODriveHandTest, IsNotArmedWithoutAWatchdogOnEveryAxis) {
  for (const Duration watchdog : {Duration::zero(), Duration(seconds(3))}) {
    bus.axis(5).watchdog = watchdog;
    make().open();
    EXPECT_THROW(hand->arm(), DeviceError);
    EXPECT_EQ(hand->fault().kind, Fault::Kind::kNoWatchdog);
    EXPECT_EQ(hand->fault().motor, 1);
    EXPECT_FALSE(hand->isArmed());
    EXPECT_NE(bus.axis(5).state, odrive::AxisState::kClosedLoop);
    bus.axis(0).error = bus.axis(5).error = 0;
  }
}

// One that was switched on without being saved is gone when the axis restarts.
TEST_F(ODriveHandTest, AnAxisThatMayHaveRestartedProvesItsWatchdogAnew) {
  make().open();
  hand->arm();
  hand->disarm();
  bus.restart(5, milliseconds(230));
  bus.axis(5).watchdog = Duration::zero();
  cycle(50);
  ASSERT_FALSE(hand->fault()) << "too short to be told: " << describe(hand->fault());
  EXPECT_THROW(hand->arm(), DeviceError);
  EXPECT_EQ(hand->fault().kind, Fault::Kind::kNoWatchdog);
  EXPECT_EQ(hand->fault().motor, 1);
}

TEST_F(ODriveHandTest, AnotherErrorWhileTheWatchdogIsProvedIsNotCleared) {
  make().open();
  hand->stopWhen([this] {
    // Asked between the steps: here, once the loops are closed.
    if (bus.axis(5).state == odrive::AxisState::kClosedLoop)
      test::ODriveEmulator::fail(bus.axis(5), 0x400);
    return false;
  });
  EXPECT_THROW(hand->arm(), DeviceError);
  EXPECT_EQ(bus.axis(5).error & 0x400u, 0x400u);
  EXPECT_FALSE(hand->isArmed());
}

TEST_F(ODriveHandTest, AStopIsHeededWhileTheWatchdogIsProved) {
  make().open();
  bool has_power = false;
  hand->stopWhen([&] {
    has_power = has_power || bus.axis(0).state == odrive::AxisState::kClosedLoop;
    return has_power;
  });
  EXPECT_THROW(hand->arm(), DeviceError);
  EXPECT_EQ(bus.axis(0).error, odrive::kEstopRequested);
}

TEST_F(ODriveHandTest, CountsFromWhereItIsToldUntilItRestarts) {
  make().open();
  bus.axis(5).servo.position = 0.25;
  EXPECT_TRUE(hand->recount(1, 100.0));
  ASSERT_TRUE(hand->read(state));
  EXPECT_NEAR(state.position[1], 100.0, 1e-4);
  bus.restart(5);
  wire->pass(milliseconds(600));
  make().open();
  ASSERT_TRUE(hand->read(state));
  EXPECT_NEAR(state.position[1], 0.0, 1e-4);
  bus.axis(5).takes_positions = false;
  EXPECT_FALSE(hand->recount(1, 100.0)) << "read back, not believed";
}

TEST_F(ODriveHandTest, TheAttendedAxisTellsItsCurrentInEveryCycle) {
  make().open();
  hand->attend(1);
  hand->arm();
  for (int i = 0; i < 8; ++i) {
    bus.axis(5).current_A = static_cast<float>(i);
    cycle(2);
    EXPECT_EQ(state.current[1], i);
  }
  bus.axis(5).tells_current = false;
  cycle(6);
  EXPECT_TRUE(std::isnan(state.current[1])) << "an old one is not passed off as new";
}

TEST_F(ODriveHandTest, TellsTheHotterTemperature) {
  bus.axis(5).heat = {41.0f, 63.0f};
  make().open();
  cycle(6);
  EXPECT_EQ(state.temperature, (std::vector<double>{40.0, 63.0}));
}

TEST_F(ODriveHandTest, OtherNodesAreStrayAndChangeNothing) {
  bus.axis(20).error = 0x40;
  bus.axis(20).servo.position = 77.0;
  make().open();
  hand->arm();
  cycle(50);
  EXPECT_FALSE(hand->fault());
  EXPECT_GT(hand->counters().stray, 20u);
}

// A clock that goes on while frames are taken, as real ones do: what came by itself since the
// last cycle must not wait behind, or what is measured gets older and older.
TEST_F(ODriveHandTest, WhatCameByItselfDoesNotPileUp) {
  bus.estimate_period = milliseconds(2);
  auto spent = std::make_shared<Duration>(0);
  hand = std::make_unique<ODriveHand>(twoAxes(), can, [spent, told = wire->clock()] {
    *spent += std::chrono::microseconds(2);
    return told() + *spent;
  });
  hand->open();
  hand->arm();
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(hand->read(state));
    ASSERT_TRUE(hand->write(std::vector<double>{5.0, 5.0}));
    wire->pass(milliseconds(10));
    const double way = bus.axis(5).servo.speed * 2.0 * std::numbers::pi * 0.02;
    ASSERT_NEAR(state.position[1], bus.axis(5).servo.position * 2.0 * std::numbers::pi, way)
        << "cycle " << i;
  }
}

TEST_F(ODriveHandTest, WorksWithAxesThatTellEstimatesOnRequestAlone) {
  bus.estimate_period = Duration::zero();
  make().open();
  hand->arm();
  cycle(50);
  EXPECT_FALSE(hand->fault());
  EXPECT_NEAR(state.position[1], bus.axis(5).servo.position * 2.0 * std::numbers::pi, 1e-5);
}

TEST_F(ODriveHandTest, TellsTheCurrentOfEachAxisInTurn) {
  make().open();
  EXPECT_TRUE(hand->read(state));
  cycle(5);
  EXPECT_EQ(state.current, (std::vector<double>{0.25, 0.25}));
}

TEST_F(ODriveHandTest, SaysWhichAxisIsMissing) {
  bus.axis(5).is_unplugged = true;
  try {
    make().open();
    ADD_FAILURE();
  } catch (const DeviceError& error) {
    EXPECT_STREQ(error.what(), "ODrive node 5: no heartbeat");
  }
}

TEST_F(ODriveHandTest, ConfigurationsAreChecked) {
  EXPECT_THROW(make(ODriveConfig{}), InvalidInput);
  ODriveConfig config = twoAxes();
  config.axes[1].node = 0;
  EXPECT_THROW(make(config), InvalidInput);
  config.axes[1].node = 64;
  EXPECT_THROW(make(config), InvalidInput);
  config = twoAxes();
  config.axes[0].current_limit_A = 0.0;
  EXPECT_THROW(make(config), InvalidInput);
  config = twoAxes();
  config.axes[0].velocity_limit_rev_s = std::nan("");
  EXPECT_THROW(make(config), InvalidInput);
  config = twoAxes();
  config.heartbeat_timeout = Duration::zero();
  EXPECT_THROW(make(config), InvalidInput);
}

}  // namespace
}  // namespace handgraft::devices
