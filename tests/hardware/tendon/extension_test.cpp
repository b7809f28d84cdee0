#include "hardware/tendon/extension.h"

#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/tendon/spool.h"

namespace handgraft::tendon {
namespace {

std::vector<Extension> allKinds() {
  return {Extension::constantArm(0.009), Extension::constantArm(-0.004),
          Extension::quadratic(0.006, 0.002), Extension::channel(0.008, 0.011, 0.006),
          Extension::channel(0.01, 0.01, 0)};
}

TEST(Extension, IsNothingAtZero) {
  for (const Extension& extension : allKinds())
    EXPECT_NEAR(extension.at(0).e, 0, 1e-17);
}

TEST(Extension, SlopesAndCurvaturesMatchCentralDifferences) {
  constexpr double kStep = 1e-5;
  for (const Extension& extension : allKinds()) {
    for (double q = -0.3; q < 1.6; q += 0.1) {
      const auto before = extension.at(q - kStep), after = extension.at(q + kStep);
      EXPECT_NEAR(extension.at(q).slope, (after.e - before.e) / (2 * kStep), 1e-10);
      EXPECT_NEAR(extension.at(q).curvature, (after.slope - before.slope) / (2 * kStep), 1e-9);
    }
  }
}

TEST(Extension, AChannelIsTheDistanceBetweenItsExits) {
  // The joint's axis is the origin, the proximal link lies along -x, the palm is at -y; the
  // distal exit turns about the axis.
  const double a = 0.008, b = 0.011, y = 0.006;
  const Extension channel = Extension::channel(a, b, y);
  for (double q = -0.3; q < 1.6; q += 0.05) {
    const Eigen::Vector2d proximal(-a, -y);
    const Eigen::Vector2d distal = Eigen::Rotation2Dd(-q) * Eigen::Vector2d(b, -y);
    EXPECT_NEAR(channel.at(q).e, a + b - (distal - proximal).norm(), 1e-16);
  }
}

TEST(Extension, BoundsHoldEverywhere) {
  const Range range{-0.2, 1.5};
  for (const Extension& extension : allKinds()) {
    const Range slopes = extension.slopes(range), e = extension.excursions(range);
    for (double q = range.lower; q <= range.upper; q += 0.0137) {
      EXPECT_LE(slopes.lower, extension.at(q).slope + 1e-6);
      EXPECT_GE(slopes.upper, extension.at(q).slope - 1e-6);
      EXPECT_LE(e.lower, extension.at(q).e + 1e-9);
      EXPECT_GE(e.upper, extension.at(q).e - 1e-9);
      EXPECT_GE(extension.largestCurvature(range), extension.at(q).curvature - 1e-5);
    }
  }
}

TEST(Extension, RefusesNumbersThatMeanNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Extension::constantArm(nan), InvalidInput);
  EXPECT_THROW(Extension::quadratic(0.01, nan), InvalidInput);
  EXPECT_THROW(Extension::channel(0, 0.01, 0), InvalidInput);
  EXPECT_THROW(Extension::channel(0.01, nan, 0), InvalidInput);
  EXPECT_THROW(Extension::channel(0.01, 0.01, -1), InvalidInput);
}

TEST(Spool, WindsAndUnwindsToTheSame) {
  for (const Spool& spool : {Spool{0.006, 0}, Spool{0.006, 0.0005}, Spool{0.02, 1e-7}}) {
    for (double e = -0.02; e < 0.1; e += 0.005)
      EXPECT_NEAR(spool.excursionAt(spool.angleAt(e)), e, 1e-15);
  }
}

TEST(Spool, TurnsAtTheRadiusThatItHas) {
  const Spool spool{0.006, 0.0005};
  constexpr double kStep = 1e-6;
  for (double e = -0.01; e < 0.1; e += 0.01) {
    const double turn = (spool.angleAt(e + kStep) - spool.angleAt(e - kStep)) / (2 * kStep);
    EXPECT_NEAR(1 / turn, spool.radiusAt(e), 1e-9);
  }
  // One turn of line of 0.5 mm raises the radius by 0.5 mm, to first order.
  EXPECT_NEAR(spool.radiusAt(2 * M_PI * 0.006), 0.0065, 1e-12);
}

TEST(Spool, WithLittleGrowthIsNearlyOneWithout) {
  EXPECT_NEAR((Spool{0.006, 1e-12}.angleAt(0.05)), (Spool{0.006, 0}.angleAt(0.05)), 1e-7);
}

}  // namespace
}  // namespace handgraft::tendon
