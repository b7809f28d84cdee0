#include "hardware/bridge/simulated_device.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;

/// A clock that moves when it is told to.
class VirtualClock {
 public:
  devices::Clock reader() {
    return [this] {
      return now;
    };
  }

  void advance(double seconds) {
    now += std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(seconds));
  }

  std::chrono::steady_clock::time_point now{std::chrono::hours(1)};
};

class SimulatedDeviceTest : public testing::Test {
 protected:
  SimulatedDevice handOf(const std::vector<SimulatedMotor>& motors) {
    return SimulatedDevice(motors, clock.reader(), kTau);
  }

  devices::DeviceState read(SimulatedDevice& hand) {
    devices::DeviceState state(hand.motorCount());
    EXPECT_TRUE(hand.read(state));
    return state;
  }

  static constexpr double kTau = 0.05;
  VirtualClock clock;
};

TEST_F(SimulatedDeviceTest, ApproachesItsTargetExponentially) {
  SimulatedDevice hand = handOf({{-1, 1, kInfinity, 0.2}});
  hand.open();
  hand.arm();
  hand.write(std::vector{0.8});
  for (int k = 1; k <= 20; ++k) {
    clock.advance(0.01);
    const double left = 0.6 * std::exp(-k * 0.01 / kTau);
    EXPECT_NEAR(read(hand).position[0], 0.8 - left, 1e-9);
    EXPECT_NEAR(read(hand).velocity[0], left / kTau, 1e-8);
  }
}

TEST_F(SimulatedDeviceTest, NeverExceedsItsTopSpeed) {
  SimulatedDevice hand = handOf({{-3, 3, 2, 0}});
  hand.open();
  hand.arm();
  hand.write(std::vector{2.0});
  clock.advance(0.5);
  EXPECT_NEAR(read(hand).position[0], 1.0, 1e-9);
  EXPECT_EQ(read(hand).velocity[0], 2);
  // The straight part ends V tau = 0.1 rad before the target, at 0.95 s.
  clock.advance(0.45 + kTau);
  EXPECT_NEAR(read(hand).position[0], 2 - 0.1 * std::exp(-1), 1e-9);
}

TEST_F(SimulatedDeviceTest, MovesAlikeHoweverOftenItIsAsked) {
  SimulatedDevice often = handOf({{-3, 3, 2, 0}});
  SimulatedDevice once = handOf({{-3, 3, 2, 0}});
  for (SimulatedDevice* each : {&often, &once}) {
    each->open();
    each->arm();
  }
  often.write(std::vector{-1.0});
  once.write(std::vector{-1.0});
  for (int k = 0; k < 1000; ++k) {
    clock.advance(0.0005);
    read(often);
  }
  EXPECT_NEAR(read(often).position[0], read(once).position[0], 1e-9);
}

TEST_F(SimulatedDeviceTest, StopsAtItsMechanicalStops) {
  SimulatedDevice hand = handOf({{-0.2, 1.1, 2, 9}});
  hand.open();
  hand.arm();
  EXPECT_EQ(read(hand).position[0], 1.1) << "a start outside is moved onto the stop";
  hand.write(std::vector{-7.0});
  clock.advance(100);
  EXPECT_DOUBLE_EQ(read(hand).position[0], -0.2);
}

TEST_F(SimulatedDeviceTest, StaysWhereItIsWithoutPower) {
  SimulatedDevice hand = handOf({{-3, 3, 2, 0}});
  hand.open();
  hand.arm();
  hand.write(std::vector{2.0});
  clock.advance(0.3);
  hand.stop();
  clock.advance(5);
  EXPECT_NEAR(read(hand).position[0], 0.6, 1e-9);
  EXPECT_EQ(read(hand).velocity[0], 0);
}

TEST_F(SimulatedDeviceTest, StandsStillWhenTheClockStepsBack) {
  SimulatedDevice hand = handOf({{-3, 3, 2, 0}});
  hand.open();
  hand.arm();
  hand.write(std::vector{2.0});
  clock.advance(0.3);
  const double before = read(hand).position[0];
  clock.advance(-10);
  EXPECT_EQ(read(hand).position[0], before);
}

TEST_F(SimulatedDeviceTest, SwitchedOnItHoldsWhereItStands) {
  SimulatedDevice hand = handOf({{-3, 3, 2, 0}});
  hand.open();
  hand.arm();
  hand.write(std::vector{2.0});
  clock.advance(0.3);
  hand.stop();
  EXPECT_FALSE(hand.write(std::vector{2.0})) << "without power";
  hand.arm();
  clock.advance(1);
  EXPECT_NEAR(read(hand).position[0], 0.6, 1e-9) << "not on to a goal of before";
}

TEST_F(SimulatedDeviceTest, RefusesServosThatCannotBe) {
  EXPECT_THROW(handOf({{1, -1, 2, 0}}), InvalidInput);
  EXPECT_THROW(handOf({{-1, 1, 0, 0}}), InvalidInput);
  EXPECT_THROW(handOf({{-1, 1, kNaN, 0}}), InvalidInput);
  EXPECT_THROW(handOf({{-1, 1, 2, kNaN}}), InvalidInput);
  EXPECT_THROW(handOf({{-kInfinity, kInfinity, 2, kInfinity}}), InvalidInput);
  EXPECT_THROW(SimulatedDevice({}, clock.reader(), 0), InvalidInput);
}

}  // namespace
}  // namespace handgraft::bridge
