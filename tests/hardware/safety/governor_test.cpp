// How a hand gets power and gives it up; which options mean something.

#include "hardware/safety/governor.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using State = GovernorState;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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
  rig.offer({0.6, 0.0});  // a step that is not long
  rig.follow(10);
  const double before = rig.position[0];
  rig.follow(1);
  EXPECT_NEAR((before - rig.position[0]) / 0.01, 1.0, 1e-9);
}

TEST(Governor, GoesSlowlyToEveryLongStepFromRest) {
  Rig rig;
  rig.armUp();
  for (const double far : {1.2, -0.8, 1.2}) {
    for (int k = 0; k < 3000 && rig.governor.isRamping(); ++k)
      rig.follow(1);
    rig.follow(100);
    rig.offer({far, 0.0});
    double fastest = 0;
    for (int k = 0; k < 100; ++k) {
      const double before = rig.position[0];
      rig.follow(1);
      fastest = std::max(fastest, std::abs(rig.position[0] - before) / 0.01);
    }
    EXPECT_TRUE(rig.governor.isRamping());
    EXPECT_LT(fastest, 0.1 + 1e-9) << "to " << far;
  }
}

TEST(Governor, GoesSlowlyWhereATargetJumpsOnTheWay) {
  Rig rig;
  rig.armUp();
  rig.offer({0.4, 0.0});
  rig.follow(10);
  EXPECT_FALSE(rig.governor.isRamping());
  rig.offer({-0.9, 0.0});
  rig.follow(2);
  EXPECT_TRUE(rig.governor.isRamping());
}

TEST(Governor, FollowsAStreamOfShortStepsAtFullSpeed) {
  Rig rig;
  rig.armUp();
  double fastest = 0;
  for (int k = 0; k < 100; ++k) {
    rig.offer({0.05 + 0.01 * k, 0.0});
    const double before = rig.position[0];
    rig.follow(1);
    fastest = std::max(fastest, (rig.position[0] - before) / 0.01);
    EXPECT_FALSE(rig.governor.isRamping());
  }
  EXPECT_NEAR(fastest, 1.0, 0.05);
}

TEST(Governor, RefusesToArmWithAMotorOutsideItsRangeAndFaultsWithOneUnderPower) {
  Rig rig;
  rig.motors_outside = true;
  rig.follow(2);
  EXPECT_EQ(rig.arm(), Refusal::kMotorsOutside);
  rig.motors_outside = false;
  rig.armUp();
  rig.motors_outside = true;
  rig.follow(1);
  EXPECT_EQ(rig.governor.fault(), FaultCause::kMotorsOutside);
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
    o.near.rad = kNaN;
  });
  refuses([](auto& o) {
    o.ramp_share = 0;
  });
  refuses([](auto& o) {
    o.ramp_share = 1.5;
  });
  refuses([](auto& o) {
    o.outside.m = kNaN;
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
