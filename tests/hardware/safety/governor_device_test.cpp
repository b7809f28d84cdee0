// What a governor makes of a device that fails, and of time that does.

#include <limits>

#include <gtest/gtest.h>

#include "hardware/safety/governor.h"

#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using State = GovernorState;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// === The device's own deadman

TEST(Governor, FaultsWhenTheDevicesOwnDeadmanCutsPower) {
  Rig rig;
  rig.armUp();
  rig.reports_power = false;
  rig.stuck = true;
  rig.follow(1);
  EXPECT_EQ(rig.state(), State::kFault);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kPowerLost);
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, FaultsWhenMotorsDoNotGoOn) {
  Rig rig;
  rig.stuck = true;
  rig.follow(2);
  rig.arm();
  rig.follow(10);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kNoPower);
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, CutsMotorsThatDoNotGoOff) {
  Rig rig;
  rig.armUp();
  rig.stuck = true;
  rig.governor.disarm();
  rig.follow(15);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kStaysOn);
  EXPECT_EQ(rig.power, Power::kCut);
  EXPECT_EQ(rig.governor.reset(), Refusal::kMotorsOn);
}

// === Faults of the device

TEST(Governor, LatchesADeviceFaultUntilResetAndGone) {
  Rig rig;
  rig.armUp();
  rig.clears_faults = false;
  rig.fault_code = 0x20;
  rig.follow(1);
  EXPECT_EQ(rig.state(), State::kFault);
  EXPECT_EQ(rig.governor.faultCode(), 0x20u);
  EXPECT_EQ(rig.power, Power::kOff) << "at once";
  EXPECT_EQ(rig.arm(), Refusal::kFault);
  rig.follow(1);
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.follow(20);
  EXPECT_EQ(rig.state(), State::kFault) << "the cause is there";
  rig.fault_code = 0;
  rig.follow(20);
  EXPECT_EQ(rig.state(), State::kFault) << "latched without a reset";
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.follow(1);
  EXPECT_EQ(rig.state(), State::kIdle);
  rig.follow(20);
  EXPECT_EQ(rig.power, Power::kOff) << "a reset gives no power";
}

TEST(Governor, AResetTellsTheDeviceToClearItsFaultsOnce) {
  Rig rig;
  rig.tick();
  rig.fault_code = 3;
  rig.tick();
  ASSERT_EQ(rig.state(), State::kFault);
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.now += rig.period;
  const DeviceReport report{true, false, 3, false, rig.now, rig.position, false};
  EXPECT_TRUE(rig.governor.tick(report, rig.now).clear_faults);
  EXPECT_FALSE(rig.governor.tick(report, rig.now).clear_faults);
  rig.fault_code = 0;
  rig.tick();
  EXPECT_EQ(rig.state(), State::kIdle);
}

TEST(Governor, AnUnpluggedHandUnderPowerFaultsAndStaysDisarmedWhenItIsBack) {
  Rig rig;
  rig.armUp();
  rig.connected = false;
  rig.follow(1);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kDeviceLost);
  EXPECT_EQ(rig.power, Power::kCut) << "nobody is there to be braked";
  rig.connected = true;
  rig.follow(50);
  EXPECT_EQ(rig.state(), State::kFault);
  EXPECT_NE(rig.power, Power::kOn);
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.follow(50);
  EXPECT_EQ(rig.state(), State::kIdle);
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, AnUnpluggedIdleHandIsDisconnectedAndComesBackIdle) {
  Rig rig;
  rig.follow(2);
  rig.connected = false;
  rig.follow(2);
  EXPECT_EQ(rig.state(), State::kDisconnected);
  rig.connected = true;
  rig.follow(2);
  EXPECT_EQ(rig.state(), State::kIdle);
}

TEST(Governor, FaultsWhenTheDeviceFallsSilent) {
  Rig rig;
  rig.armUp();
  rig.silent = true;
  rig.follow(1);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kDeviceSilent);
}

TEST(Governor, FaultsOnAMeasuredPoseThatIsNone) {
  for (const std::vector<double>& bad : {std::vector{kNaN, 0.0}, std::vector{0.0}}) {
    Rig rig;
    rig.armUp();
    rig.position = bad;
    rig.follow(1);
    EXPECT_EQ(rig.governor.fault(), FaultCause::kBadMeasurement);
    EXPECT_NE(rig.power, Power::kOn);
  }
}

TEST(Governor, FaultsWhenTheHandIsFarOutsideItsLimits) {
  Rig rig;
  rig.armUp();
  rig.position = {1.71, 0};
  rig.follow(1);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kOutOfRange);
}

TEST(Governor, HoldsWhenAMotorDoesNotObeyForLong) {
  Rig rig;
  rig.armUp();
  rig.limited = true;
  rig.follow(2);
  EXPECT_EQ(rig.state(), State::kArmed) << "a moment is permitted";
  rig.follow(2);
  EXPECT_EQ(rig.state(), State::kHolding);
  EXPECT_EQ(rig.governor.hold(), HoldCause::kMotorLimited);
  EXPECT_EQ(rig.arm(), Refusal::kNone) << "opening may be what frees it";
}

// === Time

TEST(Governor, FaultsAfterAGapUnderPower) {
  Rig rig;
  rig.armUp();
  rig.tick(2s);  // SIGSTOP
  EXPECT_EQ(rig.governor.fault(), FaultCause::kGap);
  EXPECT_EQ(rig.power, Power::kOff);
  EXPECT_GE(rig.governor.counters().longest_gap, Time::duration(2s));
}

TEST(Governor, CountsOverrunsAndFaultsWhenTheyDoNotEnd) {
  Rig rig;
  rig.armUp();
  for (int i = 0; i < 4; ++i) {
    rig.offer();
    rig.tick(8ms);
  }
  EXPECT_EQ(rig.state(), State::kArmed);
  rig.follow(1);
  EXPECT_EQ(rig.governor.counters().overruns, 4u);
  for (int i = 0; i < 5; ++i) {
    rig.offer();
    rig.tick(8ms);
  }
  EXPECT_EQ(rig.governor.fault(), FaultCause::kOverruns);
}

TEST(Governor, DoesNotCatchUpAfterALatePeriod) {
  Rig rig;
  rig.armUp();
  rig.offer({0.5, 0.5});
  rig.follow(10);
  const double before = rig.position[0];
  rig.offer();
  rig.tick(15ms);
  EXPECT_NEAR(rig.position[0] - before, 0.01, 1e-9) << "one period's way at 1 rad/s";
}

}  // namespace
}  // namespace handgraft::safety
