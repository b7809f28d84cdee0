#include "hardware/safety/governor.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using State = GovernorState;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::uint64_t count(const Rig& rig, SampleVerdict verdict) {
  return rig.governor.counters().samples[static_cast<std::size_t>(verdict)];
}

bool moves(Rig& rig) {
  const std::vector<double> before = rig.sent;
  rig.tick();
  return rig.sent != before;
}

// === Arming

TEST(Governor, StartsDisconnectedAndPowerless) {
  Rig rig;
  EXPECT_EQ(rig.state(), State::kDisconnected);
  rig.connected = false;
  rig.offer();
  EXPECT_EQ(rig.tick(), Power::kOff);
  EXPECT_EQ(rig.state(), State::kDisconnected);
  EXPECT_EQ(rig.arm(), Refusal::kNotConnected);
}

TEST(Governor, IsIdleWithoutPowerUntilItIsAskedToArm) {
  Rig rig;
  rig.follow(50);
  EXPECT_EQ(rig.state(), State::kIdle);
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, ArmsWhereTheHandIsThenFollows) {
  Rig rig;
  rig.position = {0.02, 0.04};
  rig.tick();
  rig.offer({0.06, 0.07});
  ASSERT_EQ(rig.arm(), Refusal::kNone);
  EXPECT_EQ(rig.tick(), Power::kOn);
  EXPECT_EQ(rig.sent, (std::vector{0.02, 0.04})) << "power goes on where the hand is";
  rig.follow(60);
  EXPECT_EQ(rig.sent, (std::vector{0.06, 0.07}));
  EXPECT_EQ(rig.state(), State::kArmed);
}

TEST(Governor, SendsTheMeasuredPoseUntilTheDeviceReportsPower) {
  Rig rig;
  rig.tick();
  rig.offer({0.06, 0.07});
  ASSERT_EQ(rig.arm(), Refusal::kNone);
  rig.stuck = true;
  for (int i = 0; i < 4; ++i) {
    rig.position = {0.01 * i, 0};
    rig.follow(1);
    EXPECT_EQ(rig.sent[0], 0.01 * i);
  }
}

TEST(Governor, RefusesToArmWithoutAFreshStream) {
  Rig rig;
  rig.tick();
  EXPECT_EQ(rig.arm(), Refusal::kNoFreshStream);
  rig.offer();
  rig.tick(4);
  EXPECT_EQ(rig.arm(), Refusal::kNoFreshStream) << "40 ms is stale";
  EXPECT_EQ(rig.tick(), Power::kOff);
  rig.offer();
  EXPECT_EQ(rig.arm(), Refusal::kNone);
}

TEST(Governor, RefusesToArmAHandMeasuredFarOutsideItsLimits) {
  Rig rig;
  rig.position = {-1.3, 0};
  rig.follow(2);
  EXPECT_EQ(rig.arm(), Refusal::kOutOfRange);
  EXPECT_EQ(rig.tick(), Power::kOff);
}

TEST(Governor, RefusesToArmMotorsThatAreOnAlready) {
  Rig rig;
  rig.reports_power = rig.stuck = true;
  rig.follow(2);
  EXPECT_EQ(rig.arm(), Refusal::kMotorsOn);
}

TEST(Governor, RampsToAFirstTargetThatIsFarAndThenFollowsAtFullSpeed) {
  Rig rig;
  rig.tick();
  rig.offer({1.0, 0.0});
  ASSERT_EQ(rig.arm(), Refusal::kNone);
  rig.follow(10);
  EXPECT_TRUE(rig.governor.isRamping());
  double fastest = 0;
  while (rig.governor.isRamping() && rig.now < Time{2h}) {
    const double before = rig.position[0];
    rig.follow(1);
    if (rig.governor.isRamping())
      fastest = std::max(fastest, (rig.position[0] - before) / 0.01);
  }
  EXPECT_NEAR(fastest, 0.1, 1e-9) << "a tenth of 1 rad/s";
  EXPECT_NEAR(rig.position[0], 0.9, 0.01);
  rig.follow(100);
  rig.offer({0.0, 0.0});
  rig.follow(20);
  const double before = rig.position[0];
  rig.follow(1);
  EXPECT_NEAR((before - rig.position[0]) / 0.01, 1.0, 1e-9);
}

TEST(Governor, DoesNotRampToATargetThatIsNear) {
  Rig rig;
  rig.tick();
  rig.offer({0.1, -0.1});
  ASSERT_EQ(rig.arm(), Refusal::kNone);
  EXPECT_FALSE(rig.governor.isRamping());
}

TEST(Governor, BeginsWhereTheHandIsOnceADeviceThatTookLongHasPower) {
  Rig rig;
  rig.tick();
  rig.offer({0.06, 0.07});
  ASSERT_EQ(rig.arm(), Refusal::kNone);
  rig.tick();
  rig.position = {0.011, -0.013};  // it moved while its driver waited for the motors
  rig.now += 600ms;
  rig.follow(1);
  EXPECT_EQ(rig.state(), State::kArmed) << "a late period without power is no gap";
  EXPECT_NEAR(rig.sent[0], 0.011, 3e-3) << "one step from there";
  EXPECT_NEAR(rig.sent[1], -0.013, 3e-3);
}

// === Samples

TEST(Governor, RejectsSamplesByReasonAndFollowsNoneOfThem) {
  Rig rig;
  rig.armUp();
  rig.follow(50);
  const std::vector<double> stood = rig.position;
  const std::vector<std::string> swapped{"thumb", "thumb"};
  const std::vector<double> wild{1.0, 1.0};
  Governor& governor = rig.governor;
  EXPECT_EQ(rig.governor.offer({1, 900, 0, rig.names, std::vector{kNaN, 1.0}}, rig.now),
            SampleVerdict::kNotFinite);
  EXPECT_EQ(governor.offer({1, 900, 0, rig.names, std::vector{1.0}}, rig.now),
            SampleVerdict::kWrongLength);
  EXPECT_EQ(governor.offer({1, 900, 0, swapped, wild}, rig.now), SampleVerdict::kWrongNames);
  EXPECT_EQ(governor.offer({1, rig.sequence, 0, rig.names, wild}, rig.now),
            SampleVerdict::kRepeated);
  EXPECT_EQ(governor.offer({1, rig.sequence - 1, 0, rig.names, wild}, rig.now),
            SampleVerdict::kLate);
  EXPECT_EQ(governor.offer({1, 900, -5, rig.names, wild}, rig.now), SampleVerdict::kBackwards);
  rig.tick(2);
  EXPECT_EQ(rig.position, stood);
  for (const SampleVerdict verdict :
       {SampleVerdict::kNotFinite, SampleVerdict::kWrongLength, SampleVerdict::kWrongNames,
        SampleVerdict::kRepeated, SampleVerdict::kLate, SampleVerdict::kBackwards})
    EXPECT_EQ(count(rig, verdict), 1u) << toString(verdict);
}

TEST(Governor, RejectedSamplesDoNotKeepTheStreamFresh) {
  Rig rig;
  rig.armUp();
  for (int i = 0; i < 4; ++i) {
    rig.governor.offer({1, rig.sequence, 0, rig.names, rig.pose}, rig.now);
    rig.governor.offer({1, 999, 0, rig.names, std::vector{kNaN, 0.0}}, rig.now);
    rig.tick();
  }
  EXPECT_EQ(rig.state(), State::kHolding);
}

TEST(Governor, ClampsTargetsInsideTheLimitsByTheMarginAndCountsIt) {
  Rig rig;
  rig.armUp();
  rig.offer({9.0, -9.0});
  EXPECT_DOUBLE_EQ(rig.governor.target()[0], 1.5 - 1e-4);
  EXPECT_DOUBLE_EQ(rig.governor.target()[1], -1 + 1e-4);
  EXPECT_EQ(rig.governor.counters().clamped_samples, 1u);
}

TEST(Governor, TellsTheAgeOfTheNewestPose) {
  Rig rig;
  EXPECT_FALSE(rig.governor.commandAge(rig.now));
  rig.offer();
  rig.tick(3);
  EXPECT_EQ(rig.governor.commandAge(rig.now), Time::duration(30ms));
}

TEST(Governor, CountsWhatTheLimiterDid) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 0.05});
  rig.follow(30);
  EXPECT_GT(rig.governor.counters().at_velocity, 10u);
  EXPECT_GE(rig.governor.counters().at_acceleration, 1u);
}

// === The deadmen

TEST(Governor, HoldsOnAStaleStreamThenSwitchesOff) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(10);
  rig.tick(2);
  ASSERT_EQ(rig.state(), State::kArmed) << "30 ms are not stale";
  rig.tick();
  ASSERT_EQ(rig.state(), State::kHolding);
  EXPECT_EQ(rig.governor.hold(), HoldCause::kStale);
  rig.tick(4);
  EXPECT_FALSE(moves(rig)) << "braked";
  EXPECT_EQ(rig.power, Power::kOn) << "holds under power";
  rig.tick(2);
  EXPECT_EQ(rig.power, Power::kOff) << "60 ms after the hold began";
  EXPECT_EQ(rig.state(), State::kIdle);
  EXPECT_EQ(rig.governor.counters().stale_streams, 1u);
}

TEST(Governor, AReturningStreamNeverResumesMotion) {
  Rig rig;
  rig.armUp();
  rig.tick(5);
  ASSERT_EQ(rig.state(), State::kHolding);
  rig.offer({1.0, 1.0});
  rig.follow(2);
  EXPECT_FALSE(moves(rig));
  rig.follow(100);
  EXPECT_EQ(rig.state(), State::kIdle);
  EXPECT_EQ(rig.power, Power::kOff);
  EXPECT_EQ(rig.arm(), Refusal::kNone) << "an enable edge does";
}

TEST(Governor, ArmEndsAHoldWithoutLosingPower) {
  Rig rig;
  rig.armUp();
  rig.tick(5);
  ASSERT_EQ(rig.state(), State::kHolding);
  EXPECT_EQ(rig.arm(), Refusal::kNoFreshStream);
  rig.offer({0.3, 0.3});
  EXPECT_EQ(rig.arm(), Refusal::kNone);
  for (int i = 0; i < 200; ++i) {
    rig.follow(1);
    EXPECT_EQ(rig.power, Power::kOn);
  }
  EXPECT_EQ(rig.position, (std::vector{0.3, 0.3}));
}

TEST(Governor, ARenewalKeepsAQuietStreamFresh) {
  Rig rig;
  rig.armUp();
  for (int i = 0; i < 20; ++i) {
    rig.governor.renew(1, rig.now);
    rig.tick();
  }
  EXPECT_EQ(rig.state(), State::kArmed);
  for (int i = 0; i < 20; ++i) {
    rig.governor.renew(2, rig.now);  // not the stream that is followed
    rig.tick();
  }
  EXPECT_NE(rig.state(), State::kArmed);
}

TEST(Governor, AnotherStreamMakesAnArmedHandHold) {
  Rig rig;
  rig.armUp();
  rig.stream = 2;
  rig.sequence = 0;
  rig.offer({1.0, 1.0});
  EXPECT_EQ(rig.state(), State::kHolding);
  EXPECT_EQ(rig.governor.hold(), HoldCause::kStreamChanged);
  rig.follow(2);
  EXPECT_EQ(rig.arm(), Refusal::kNone) << "the new stream may be armed";
}

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
  const DeviceReport report{true, false, 3, false, rig.now, rig.position};
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

// === Emergency stop

TEST(Governor, BrakesWithinTheLimitsThenCutsPowerOnAnEmergencyStop) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  EXPECT_EQ(rig.state(), State::kEStop);
  int steps = 0;
  double before = rig.position[0];
  while (rig.tick() == Power::kOn && steps < 100) {
    EXPECT_GE(rig.position[0], before) << "it does not turn back";
    before = rig.position[0];
    ++steps;
  }
  EXPECT_GE(steps, 2);
  EXPECT_LE(steps, 5) << "1 rad/s at 50 rad/s^2, and the average of 2";
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, CutsAtOnceWhenItsHandIsToBeCut) {
  GovernorOptions options = quickOptions();
  options.stop_mode = StopMode::kCut;
  Rig rig(options);
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  EXPECT_EQ(rig.tick(), Power::kCut) << "the next order";
  EXPECT_TRUE(rig.sent.empty());
  EXPECT_EQ(rig.tick(), Power::kCut) << "again, in case that one was lost";
}

TEST(Governor, AnEmergencyStopOverridesEveryStateAndIsLeftByResetAlone) {
  for (int before = 0; before < 5; ++before) {
    Rig rig;
    if (before == 0) rig.connected = false;
    if (before >= 2) rig.armUp();
    if (before == 3) rig.tick(5);
    if (before == 4) rig.fault_code = 1;
    rig.tick();
    rig.governor.estop();
    rig.fault_code = 0;
    rig.connected = true;
    rig.follow(100);
    EXPECT_EQ(rig.state(), State::kEStop);
    EXPECT_EQ(rig.arm(), Refusal::kEStop);
    rig.governor.disarm();
    rig.follow(5);
    EXPECT_EQ(rig.state(), State::kEStop);
    EXPECT_NE(rig.power, Power::kOn);
    EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
    rig.follow(5);
    EXPECT_EQ(rig.state(), State::kIdle) << "from state " << before;
    EXPECT_EQ(rig.power, Power::kOff);
  }
}

TEST(Governor, RefusesAResetWhileTheHandStillBrakes) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  rig.tick();
  EXPECT_EQ(rig.governor.reset(), Refusal::kMotorsOn);
}

TEST(Governor, ASecondEmergencyStopUndoesAResetUnderWay) {
  Rig rig;
  rig.follow(1);
  rig.governor.estop();
  rig.follow(1);
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.governor.estop();
  rig.follow(5);
  EXPECT_EQ(rig.state(), State::kEStop);
}

TEST(Governor, CutsOnAnEmergencyStopOfAHandThatCannotBeHeard) {
  Rig rig;
  rig.armUp();
  rig.connected = false;
  rig.tick();
  rig.governor.estop();
  EXPECT_EQ(rig.tick(), Power::kCut);
}

TEST(Governor, HasNothingToResetWhenNothingIsLatched) {
  Rig rig;
  rig.armUp();
  EXPECT_EQ(rig.governor.reset(), Refusal::kNothingToReset);
  EXPECT_EQ(rig.state(), State::kArmed);
}

// === Disarming

TEST(Governor, DisarmsByBrakingThenPowerOff) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.disarm();
  rig.follow(1);
  EXPECT_EQ(rig.power, Power::kOn);
  EXPECT_EQ(rig.state(), State::kHolding);
  rig.follow(5);
  EXPECT_EQ(rig.power, Power::kOff);
  EXPECT_EQ(rig.state(), State::kIdle);
  rig.follow(50);
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, DisarmBeforePowerIsOnNeedsNoBraking) {
  Rig rig;
  rig.follow(1);
  rig.arm();
  rig.governor.disarm();
  EXPECT_EQ(rig.tick(), Power::kOff);
  EXPECT_EQ(rig.state(), State::kIdle);
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
  rig.offer({1.0, 1.0});
  rig.follow(20);
  const double before = rig.position[0];
  rig.offer();
  rig.tick(15ms);
  EXPECT_NEAR(rig.position[0] - before, 0.01, 1e-9) << "one period's way at 1 rad/s";
}

// === Options

TEST(Governor, RefusesOptionsThatMeanNothing) {
  const auto refuses = [](auto spoil) {
    GovernorOptions options = quickOptions();
    spoil(options);
    EXPECT_THROW(Governor{options}, InvalidInput);
  };
  refuses([](auto& o) {
    o.names = {"a"};
  });
  refuses([](auto& o) {
    o.names = {"a", "a"};
  });
  refuses([](auto& o) {
    o.names = {"a", ""};
  });
  refuses([](auto& o) {
    o.names.clear(), o.limits.clear();
  });
  refuses([](auto& o) {
    o.limits[1].velocity = 0;
  });
  refuses([](auto& o) {
    o.stale_after = 0ms;
  });
  refuses([](auto& o) {
    o.hold_for = -1ms;
  });
  refuses([](auto& o) {
    o.near = kNaN;
  });
  refuses([](auto& o) {
    o.ramp_share = 0;
  });
  refuses([](auto& o) {
    o.ramp_share = 1.5;
  });
  refuses([](auto& o) {
    o.outside = kNaN;
  });
  refuses([](auto& o) {
    o.overruns_in_a_row = 0;
  });
  refuses([](auto& o) {
    o.brake_within = 20ms;
  });
}

}  // namespace
}  // namespace handgraft::safety
