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
      : bus_({0, 5, 20}, odrive::Firmware::k06),
        adapter_(bus_),
        wire_(test::makeVirtualWire(adapter_)),
        can_(wire_->channel(), 500000, wire_->clock()),
        state_(2) {}

  ODriveHand& make(const ODriveConfig& config = twoAxes()) {
    hand_ = std::make_unique<ODriveHand>(config, can_, wire_->clock());
    return *hand_;
  }

  void cycle(int count = 1) {
    for (int i = 0; i < count; ++i) {
      static_cast<void>(hand_->read(state_));
      static_cast<void>(hand_->write(std::vector<double>{1.0, 1.0}));
      wire_->pass(milliseconds(10));
    }
  }

  test::ODriveEmulator bus_;
  test::SlcanEmulator adapter_;
  std::unique_ptr<test::Wire> wire_;
  SlcanChannel can_;
  std::unique_ptr<ODriveHand> hand_;
  DeviceState state_;
};

TEST_F(ODriveHandTest, ArmingSetsLimitsOnItsAxesAlone) {
  ODriveConfig config = twoAxes();
  config.axes[1].velocity_limit_rev_s = 3.5;
  make(config).open();
  hand_->arm();
  EXPECT_EQ(bus_.axis(5).servo.speed, 3.5);
  EXPECT_EQ(bus_.axis(5).state, odrive::AxisState::kClosedLoop);
  EXPECT_EQ(bus_.axis(20).state, odrive::AxisState::kIdle);
}

TEST_F(ODriveHandTest, ArmingNeverClearsErrors) {
  test::ODriveEmulator::fail(bus_.axis(5), 0x100);
  make().open();
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kHardware);
  EXPECT_EQ(hand_->fault().motor, 1);
  EXPECT_EQ(hand_->fault().code, 0x100u);
  EXPECT_THROW(hand_->arm(), DeviceError);
  EXPECT_EQ(bus_.axis(5).error & 0x100u, 0x100u);
  hand_->reset();
  EXPECT_EQ(bus_.axis(5).error, 0u);
  hand_->arm();
}

TEST_F(ODriveHandTest, MissingHeartbeatsAreSilenceAlthoughEstimatesCome) {
  make().open();
  hand_->arm();
  bus_.heartbeat_period = seconds(100);
  cycle(60);
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kSilent);
}

TEST_F(ODriveHandTest, MissingEstimatesAreSilenceAlthoughHeartbeatsCome) {
  make().open();
  hand_->arm();
  bus_.axis(5).servo.position = std::nan("");  // which is not taken for a position
  cycle(6);
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kSilent);
  EXPECT_EQ(hand_->fault().motor, 1);
}

TEST_F(ODriveHandTest, AnAxisThatIsNoLongerInItsLoopHasLostItsPower) {
  make().open();
  hand_->arm();
  bus_.axis(0).state = odrive::AxisState::kIdle;
  cycle(12);
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kPowerLost);
  EXPECT_EQ(hand_->fault().motor, 0);
  EXPECT_EQ(bus_.axis(5).error, odrive::kEstopRequested) << "the others are stopped, too";
}

TEST_F(ODriveHandTest, AnotherOnesEmergencyStopIsAFault) {
  make().open();
  hand_->arm();
  test::ODriveEmulator::fail(bus_.axis(0), odrive::kEstopRequested);
  cycle(12);
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kHardware);
  EXPECT_EQ(hand_->fault().code, odrive::kEstopRequested);
}

TEST_F(ODriveHandTest, AfterItsOwnStopAnArmingNeedsAReset) {
  make().open();
  hand_->arm();
  hand_->stop();
  EXPECT_EQ(bus_.axis(0).error, odrive::kEstopRequested);
  cycle(12);
  EXPECT_THROW(hand_->arm(), DeviceError);
  hand_->reset();
  hand_->arm();
  cycle(5);
  EXPECT_FALSE(hand_->fault());
}

TEST_F(ODriveHandTest, ArmingGivesUpOnAnAxisThatDoesNotObey) {
  make().open();
  bus_.heartbeat_period = seconds(100);  // it cannot tell that it obeyed
  wire_->pass(milliseconds(150));        // the last one was on its way
  EXPECT_THROW(hand_->arm(), DeviceError);
  EXPECT_FALSE(hand_->isArmed());
  EXPECT_NE(bus_.axis(0).state, odrive::AxisState::kClosedLoop);
}

TEST_F(ODriveHandTest, TheFirstArmingProvesTheWatchdogsBySilence) {
  make().open();
  const TimePoint start = wire_->clock()();
  hand_->arm();
  EXPECT_GT(wire_->clock()() - start, milliseconds(200)) << "as long as a watchdog takes";
  EXPECT_EQ(bus_.axis(5).error, 0u) << "what was provoked is cleared";
  EXPECT_EQ(bus_.axis(5).state, odrive::AxisState::kClosedLoop);
  cycle(5);
  EXPECT_FALSE(hand_->fault());
  hand_->disarm();
  const TimePoint again = wire_->clock()();
  hand_->arm();
  EXPECT_LT(wire_->clock()() - again, milliseconds(200)) << "once after each open";
}

TEST_F(ODriveHandTest, IsNotArmedWithoutAWatchdogOnEveryAxis) {
  for (const Duration watchdog : {Duration::zero(), Duration(seconds(3))}) {
    bus_.axis(5).watchdog = watchdog;
    make().open();
    EXPECT_THROW(hand_->arm(), DeviceError);
    EXPECT_EQ(hand_->fault().kind, Fault::Kind::kNoWatchdog);
    EXPECT_EQ(hand_->fault().motor, 1);
    EXPECT_FALSE(hand_->isArmed());
    EXPECT_NE(bus_.axis(5).state, odrive::AxisState::kClosedLoop);
    bus_.axis(0).error = bus_.axis(5).error = 0;
  }
}

// One that was switched on without being saved is gone when the axis restarts.
TEST_F(ODriveHandTest, AnAxisThatMayHaveRestartedProvesItsWatchdogAnew) {
  make().open();
  hand_->arm();
  hand_->disarm();
  bus_.restart(5, milliseconds(230));
  bus_.axis(5).watchdog = Duration::zero();
  cycle(50);
  ASSERT_FALSE(hand_->fault()) << "too short to be told: " << describe(hand_->fault());
  EXPECT_THROW(hand_->arm(), DeviceError);
  EXPECT_EQ(hand_->fault().kind, Fault::Kind::kNoWatchdog);
  EXPECT_EQ(hand_->fault().motor, 1);
}

TEST_F(ODriveHandTest, AnotherErrorWhileTheWatchdogIsProvedIsNotCleared) {
  make().open();
  hand_->stopWhen([this] {
    // Asked between the steps: here, once the loops are closed.
    if (bus_.axis(5).state == odrive::AxisState::kClosedLoop)
      test::ODriveEmulator::fail(bus_.axis(5), 0x400);
    return false;
  });
  EXPECT_THROW(hand_->arm(), DeviceError);
  EXPECT_EQ(bus_.axis(5).error & 0x400u, 0x400u);
  EXPECT_FALSE(hand_->isArmed());
}

TEST_F(ODriveHandTest, AStopIsHeededWhileTheWatchdogIsProved) {
  make().open();
  bool has_power = false;
  hand_->stopWhen([&] {
    has_power = has_power || bus_.axis(0).state == odrive::AxisState::kClosedLoop;
    return has_power;
  });
  EXPECT_THROW(hand_->arm(), DeviceError);
  EXPECT_EQ(bus_.axis(0).error, odrive::kEstopRequested);
}

TEST_F(ODriveHandTest, CountsFromWhereItIsToldUntilItRestarts) {
  make().open();
  bus_.axis(5).servo.position = 0.25;
  EXPECT_TRUE(hand_->recount(1, 100.0));
  ASSERT_TRUE(hand_->read(state_));
  EXPECT_NEAR(state_.position[1], 100.0, 1e-4);
  bus_.restart(5);
  wire_->pass(milliseconds(600));
  make().open();
  ASSERT_TRUE(hand_->read(state_));
  EXPECT_NEAR(state_.position[1], 0.0, 1e-4);
  bus_.axis(5).takes_positions = false;
  EXPECT_FALSE(hand_->recount(1, 100.0)) << "read back, not believed";
}

TEST_F(ODriveHandTest, TheAttendedAxisTellsItsCurrentInEveryCycle) {
  make().open();
  hand_->attend(1);
  hand_->arm();
  for (int i = 0; i < 8; ++i) {
    bus_.axis(5).current_A = static_cast<float>(i);
    cycle(2);
    EXPECT_EQ(state_.current[1], i);
  }
  bus_.axis(5).tells_current = false;
  cycle(6);
  EXPECT_TRUE(std::isnan(state_.current[1])) << "an old one is not passed off as new";
}

TEST_F(ODriveHandTest, TellsTheHotterTemperature) {
  bus_.axis(5).heat = {41.0f, 63.0f};
  make().open();
  cycle(6);
  EXPECT_EQ(state_.temperature, (std::vector<double>{40.0, 63.0}));
}

TEST_F(ODriveHandTest, OtherNodesAreStrayAndChangeNothing) {
  bus_.axis(20).error = 0x40;
  bus_.axis(20).servo.position = 77.0;
  make().open();
  hand_->arm();
  cycle(50);
  EXPECT_FALSE(hand_->fault());
  EXPECT_GT(hand_->counters().stray, 20u);
}

// A clock that goes on while frames are taken, as real ones do: what came by itself since the
// last cycle must not wait behind, or what is measured gets older and older.
TEST_F(ODriveHandTest, WhatCameByItselfDoesNotPileUp) {
  bus_.estimate_period = milliseconds(2);
  auto spent = std::make_shared<Duration>(0);
  hand_ = std::make_unique<ODriveHand>(twoAxes(), can_, [spent, told = wire_->clock()] {
    *spent += std::chrono::microseconds(2);
    return told() + *spent;
  });
  hand_->open();
  hand_->arm();
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(hand_->read(state_));
    ASSERT_TRUE(hand_->write(std::vector<double>{5.0, 5.0}));
    wire_->pass(milliseconds(10));
    const double way = bus_.axis(5).servo.speed * 2.0 * std::numbers::pi * 0.02;
    ASSERT_NEAR(state_.position[1], bus_.axis(5).servo.position * 2.0 * std::numbers::pi, way)
        << "cycle " << i;
  }
}

TEST_F(ODriveHandTest, WorksWithAxesThatTellEstimatesOnRequestAlone) {
  bus_.estimate_period = Duration::zero();
  make().open();
  hand_->arm();
  cycle(50);
  EXPECT_FALSE(hand_->fault());
  EXPECT_NEAR(state_.position[1], bus_.axis(5).servo.position * 2.0 * std::numbers::pi, 1e-5);
}

TEST_F(ODriveHandTest, TellsTheCurrentOfEachAxisInTurn) {
  make().open();
  EXPECT_TRUE(hand_->read(state_));
  cycle(5);
  EXPECT_EQ(state_.current, (std::vector<double>{0.25, 0.25}));
}

TEST_F(ODriveHandTest, SaysWhichAxisIsMissing) {
  bus_.axis(5).is_unplugged = true;
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
