#include "hardware/safety/output_guard.h"

#include <limits>

#include <gtest/gtest.h>

namespace handgraft::safety {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr JointLimits kLimits{
    .lower = -1, .upper = 1, .velocity = 2, .acceleration = 50, .jerk = 1000};
constexpr double kT = 0.01;

OutputGuard guardAt(double start, JointLimits limits = kLimits) {
  OutputGuard guard({limits}, kT);
  guard.reset(std::vector{start});
  return guard;
}

bool permits(OutputGuard& guard, double position) {
  return guard.permits(std::vector{position});
}

TEST(OutputGuard, PermitsTheJerkAtItsLimitAndNotBeyond) {
  const double step = 1000 * kT * kT * kT;
  OutputGuard guard = guardAt(0);
  EXPECT_FALSE(permits(guard, step * 1.00001));
  EXPECT_TRUE(permits(guard, step));
}

TEST(OutputGuard, PermitsTheAccelerationAtItsLimitAndNotBeyond) {
  JointLimits limits = kLimits;
  limits.jerk = 1e9;
  const double step = 50 * kT * kT;
  OutputGuard guard = guardAt(0, limits);
  EXPECT_FALSE(permits(guard, step * 1.00001));
  EXPECT_TRUE(permits(guard, step));
  EXPECT_TRUE(permits(guard, 3 * step));
  EXPECT_FALSE(permits(guard, 6 * step * 1.00001));
}

TEST(OutputGuard, PermitsTheVelocityAtItsLimitAndNotBeyond) {
  JointLimits limits = kLimits;
  limits.jerk = limits.acceleration = 1e9;
  OutputGuard guard = guardAt(0, limits);
  EXPECT_FALSE(permits(guard, -0.02 * 1.00001));
  EXPECT_TRUE(permits(guard, -0.02));
}

TEST(OutputGuard, RefusesWhatIsOutsideTheRangeOrNoNumber) {
  OutputGuard guard = guardAt(1);
  EXPECT_FALSE(permits(guard, 1 + 1e-9));
  EXPECT_FALSE(permits(guard, kNaN));
  EXPECT_FALSE(permits(guard, std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(permits(guard, 1));
}

TEST(OutputGuard, PermitsTheWayInsideFromAStartOutside) {
  OutputGuard guard = guardAt(1.2);
  EXPECT_TRUE(permits(guard, 1.2));
  EXPECT_FALSE(permits(guard, 1.2 + 1e-6));
  EXPECT_TRUE(permits(guard, 1.2 - 1e-4));
}

TEST(OutputGuard, RefusesInfinityOfAJointWithoutRange) {
  OutputGuard guard = guardAt(0, JointLimits{});
  EXPECT_FALSE(permits(guard, std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(permits(guard, kNaN));
}

TEST(OutputGuard, RefusesAllJointsForOne) {
  OutputGuard guard({kLimits, kLimits}, kT);
  guard.reset(std::vector{0.0, 0.0});
  EXPECT_FALSE(guard.permits(std::vector{0.0, 0.5}));
  EXPECT_TRUE(guard.permits(std::vector{0.0, 0.0}));
}

}  // namespace
}  // namespace handgraft::safety
