#include "hardware/devices/motor_scale.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::devices {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::int32_t kFar = 1000000;

MotorScale randomScale(std::mt19937& random) {
  std::uniform_real_distribution<double> number(-3.0, 3.0);
  MotorScale scale;
  scale.rad_per_unit = random() % 2 == 0 ? kTurn / 4096.0 : kTurn;
  scale.zero = 100.0 * number(random);
  scale.direction = random() % 2 == 0 ? 1 : -1;
  scale.lower = number(random);
  scale.upper = scale.lower + 2.0 * kTurn;
  return scale;
}

TEST(MotorScale, AngleAndUnitsAreInverse) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-10.0, 10.0);
  for (int i = 0; i < 1000; ++i) {
    const MotorScale scale = randomScale(random);
    const double q = angle(random);
    ASSERT_NEAR(scale.angle(scale.units(q)), q, 1e-9);
  }
}

TEST(MotorScale, KnowsTheDevicesConvention) {
  // LEAP: 2048 counts are an open joint, a right angle is 1024 counts more.
  const MotorScale forth{kTurn / 4096.0, 2048.0, 1, -1.0, 2.0};
  EXPECT_EQ(forth.wholeUnits(kTurn / 4.0, -kFar, kFar), 3072);
  const MotorScale back{kTurn / 4096.0, 2048.0, -1, -1.0, 2.0};
  EXPECT_EQ(back.wholeUnits(kTurn / 4.0, -kFar, kFar), 1024);
}

TEST(MotorScale, InsideItsLimitsItRoundsToTheNearest) {
  std::mt19937 random(2);
  for (int i = 0; i < 5000; ++i) {
    const MotorScale scale = randomScale(random);
    std::uniform_real_distribution<double> angle(scale.lower + scale.rad_per_unit,
                                                 scale.upper - scale.rad_per_unit);
    const double q = scale.rad_per_unit < 1.0 ? angle(random) : scale.lower + kTurn;
    const double rounded = scale.angle(scale.wholeUnits(q, -kFar, kFar));
    ASSERT_LE(std::abs(rounded - q), 0.5 * scale.rad_per_unit * (1.0 + 1e-9));
    ASSERT_NEAR(scale.angle(scale.floatUnits(q)), q,
                scale.rad_per_unit * 1e-7 * (1.0 + std::abs(scale.units(q))));
  }
}

TEST(MotorScale, AtItsLimitsItRoundsInwards) {
  std::mt19937 random(3);
  int up = 0;
  for (int i = 0; i < 5000; ++i) {
    const MotorScale scale = randomScale(random);
    for (const double q : {scale.lower, scale.upper}) {
      const double whole = scale.angle(scale.wholeUnits(q, -kFar, kFar));
      const double single = scale.angle(scale.floatUnits(q));
      for (const double rounded : {whole, single}) {
        ASSERT_GE(rounded, scale.lower);
        ASSERT_LE(rounded, scale.upper);
      }
      ASSERT_LE(std::abs(whole - q), scale.rad_per_unit);
      up += std::abs(whole - q) > 0.5 * scale.rad_per_unit ? 1 : 0;
    }
  }
  EXPECT_GT(up, 2000) << "the nearest would have done";
}

// A motor that starts beyond its limit comes back bit by bit, not in one leap.
TEST(MotorScale, OutsideOfItsLimitsItNeverGoesFartherOut) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> beyond(0.0, 0.5);
  for (int i = 0; i < 5000; ++i) {
    const MotorScale scale = randomScale(random);
    const double above = scale.upper + beyond(random);
    ASSERT_LE(scale.angle(scale.wholeUnits(above, -kFar, kFar)), above);
    ASSERT_GE(scale.angle(scale.wholeUnits(above, -kFar, kFar)), above - scale.rad_per_unit);
    const double below = scale.lower - beyond(random);
    ASSERT_GE(scale.angle(scale.wholeUnits(below, -kFar, kFar)), below);
    ASSERT_LE(scale.angle(scale.wholeUnits(below, -kFar, kFar)), below + scale.rad_per_unit);
  }
}

TEST(MotorScale, StaysWithinWhatTheDeviceTakes) {
  const MotorScale scale{0.001, 0.0, 1, -1.0, 1.0};
  EXPECT_EQ(scale.wholeUnits(1e300, -kFar, kFar), kFar);
  EXPECT_EQ(scale.wholeUnits(-1e300, -kFar, kFar), -kFar);
  EXPECT_THROW(static_cast<void>(scale.wholeUnits(std::nan(""), -kFar, kFar)), BrokenContract);
  EXPECT_THROW(static_cast<void>(scale.floatUnits(std::nan(""))), BrokenContract);
}

TEST(MotorScale, RefusesWhatMakesNoSense) {
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  const MotorScale good{0.001, 0.0, 1, -1.0, 1.0};
  const auto refuses = [](const MotorScale& scale) {
    EXPECT_THROW(validate(scale, "thumb", -2000, 2000), InvalidInput);
  };
  EXPECT_NO_THROW(validate(good, "thumb", -2000, 2000));
  EXPECT_THROW(validate(good, "thumb", -2000, 999), InvalidInput);
  EXPECT_THROW(validate(good, "thumb", -999, 2000), InvalidInput);
  MotorScale bad = good;
  bad.direction = 0;
  refuses(bad);
  for (const double value : {nan, infinity}) {
    bad = good;
    bad.upper = value;
    refuses(bad);
    bad = good;
    bad.zero = value;
    refuses(bad);
    bad = good;
    bad.rad_per_unit = value;
    refuses(bad);
  }
  bad = good;
  bad.lower = bad.upper;
  refuses(bad);
  bad = good;
  bad.rad_per_unit = 0.0;
  refuses(bad);
}

}  // namespace
}  // namespace handgraft::devices
