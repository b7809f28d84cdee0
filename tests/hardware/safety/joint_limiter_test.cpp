#include "hardware/safety/joint_limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::safety {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-6;  // relative, of a limit

/// What was sent to one joint, and how fast its finite differences became.
class Trace {
 public:
  Trace(double start, double period) : period_(period), sent_(4, start) {}

  void add(double position) {
    sent_.push_back(position);
    const std::size_t k = sent_.size() - 1;
    const double v0 = (sent_[k] - sent_[k - 1]) / period_;
    const double v1 = (sent_[k - 1] - sent_[k - 2]) / period_;
    const double v2 = (sent_[k - 2] - sent_[k - 3]) / period_;
    velocity = std::max(velocity, std::abs(v0));
    acceleration = std::max(acceleration, std::abs(v0 - v1) / period_);
    jerk = std::max(jerk, std::abs(v0 - 2 * v1 + v2) / (period_ * period_));
    lowest = std::min(lowest, position);
    highest = std::max(highest, position);
  }

  double last() const { return sent_.back(); }

  double velocity = 0, acceleration = 0, jerk = 0;
  double lowest = kInfinity, highest = -kInfinity;

 private:
  double period_;
  std::vector<double> sent_;
};

void expectWithin(const Trace& trace, const JointLimits& limits) {
  // Third differences of positions near 1 lose about 4 ulp; that noise is not motion.
  EXPECT_LE(trace.velocity, limits.velocity * (1 + kRounding));
  EXPECT_LE(trace.acceleration, limits.acceleration * (1 + kRounding));
  EXPECT_LE(trace.jerk, limits.jerk * (1 + kRounding));
  EXPECT_GE(trace.lowest, limits.lower);
  EXPECT_LE(trace.highest, limits.upper);
}

/// Limits and periods over which each claim is checked.
struct Case {
  JointLimits limits;
  double period;
};

std::vector<Case> manyCases(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Case> cases;
  for (int i = 0; i < count; ++i) {
    Case c;
    c.limits.lower = -0.3 - unit(random);
    c.limits.upper = 0.5 + unit(random);
    c.limits.velocity = 0.2 + 6 * unit(random);
    c.limits.acceleration = 2 + 60 * unit(random);
    c.limits.jerk = 50 * std::pow(100, unit(random));
    c.period = i % 3 == 0 ? 0.001 : i % 3 == 1 ? 0.002 : 0.01;
    cases.push_back(c);
  }
  return cases;
}

/// Runs a joint from `start` to `target` until it rests, or for a minute.
Trace runTo(const Case& c, double start, double target) {
  JointLimiter limiter({c.limits}, c.period);
  limiter.reset(std::vector{start});
  limiter.aim(std::vector{target});
  Trace trace(start, c.period);
  const int steps = static_cast<int>(60 / c.period);
  for (int k = 0; k < steps && !(k > 0 && limiter.atRest()); ++k)
    trace.add(limiter.step()[0]);
  EXPECT_TRUE(limiter.atRest());
  return trace;
}

TEST(JointLimiter, KeepsEveryLimitWhateverTheTargetsDo) {
  std::mt19937 random(20260717);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const Case& c : manyCases(random, 24)) {
    JointLimiter limiter({c.limits}, c.period);
    const double start = c.limits.lower + unit(random) * (c.limits.upper - c.limits.lower);
    limiter.reset(std::vector{start});
    Trace trace(start, c.period);
    double target = start;
    for (int k = 0; k < 8000; ++k) {
      const double kind = unit(random);
      if (kind < 0.002) target = c.limits.lower + unit(random) * 3;  // a step
      if (kind > 0.002 && kind < 0.006) target = -target;            // a reversal
      if (kind > 0.006 && kind < 0.008) target = 100 * (unit(random) - 0.5);
      if (k % 2000 > 1700) target = c.limits.upper + std::sin(0.3 * k);  // noise at a limit
      const bool hostile = kind > 0.99;
      limiter.aim(std::vector{hostile ? (kind > 0.995 ? kNaN : kInfinity) : target});
      if (kind > 0.008 && kind < 0.009) limiter.brake();
      trace.add(limiter.step()[0]);
    }
    expectWithin(trace, c.limits);
    EXPECT_GT(trace.velocity, 0.1 * c.limits.velocity) << "the trace hardly moved";
  }
}

TEST(JointLimiter, ReachesAConstantTargetWithoutOvershoot) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const Case& c : manyCases(random, 60)) {
    const double reach = c.limits.upper - c.limits.lower - 2 * c.limits.margin;
    const double start = c.limits.lower + c.limits.margin + unit(random) * reach;
    const double target = c.limits.lower + c.limits.margin + unit(random) * reach;
    const Trace trace = runTo(c, start, target);
    expectWithin(trace, c.limits);
    EXPECT_EQ(trace.last(), target);
    EXPECT_LE(trace.highest, std::max(start, target) + 1e-12);
    EXPECT_GE(trace.lowest, std::min(start, target) - 1e-12);
  }
}

TEST(JointLimiter, TakesNoLongerThanTheLimitsAsk) {
  // From rest to rest over D with velocity V and acceleration A takes D/V + V/A; the average
  // adds its own length, and sampling two periods.
  const Case c{{.lower = -2, .upper = 2, .velocity = 2, .acceleration = 10, .jerk = 5000},
               0.001};
  JointLimiter limiter({c.limits}, c.period);
  limiter.reset(std::vector{0.0});
  limiter.aim(std::vector{1.0});
  int steps = 0;
  while (limiter.step()[0] != 1.0 && steps < 10000)
    ++steps;
  const double taps = 4;  // 2 A / (J dt)
  EXPECT_NEAR(steps * c.period, 1.0 / 2 + 2.0 / 10, (taps + 2) * c.period);
}

TEST(JointLimiter, StopsAtTheTargetThatARateLimiterRunsPast) {
  // The step of libfranka's rate limiter with these limits passes 1 rad by more than 15 %.
  const Case c{{.lower = -2, .upper = 2, .velocity = 2, .acceleration = 10, .jerk = 5000},
               0.001};
  const Trace trace = runTo(c, 0, 1);
  EXPECT_LE(trace.highest, 1 + 1e-4);
  EXPECT_NEAR(trace.velocity, 2, 1e-9) << "slower than it may be";
}

TEST(JointLimiter, ClampsTargetsInsideTheLimitsByTheMargin) {
  JointLimiter limiter({{.lower = -0.2, .upper = 1.5, .margin = 0.01}}, 0.01);
  limiter.reset(std::vector{0.0});
  limiter.aim(std::vector{9.0});
  EXPECT_DOUBLE_EQ(limiter.targets()[0], 1.49);
  limiter.aim(std::vector{-9.0});
  EXPECT_DOUBLE_EQ(limiter.targets()[0], -0.19);
}

TEST(JointLimiter, AimsAtTheMiddleOfARangeSmallerThanTheMargins) {
  JointLimiter limiter({{.lower = 0.3, .upper = 0.4, .margin = 0.2}}, 0.01);
  limiter.reset(std::vector{0.3});
  limiter.aim(std::vector{9.0});
  EXPECT_DOUBLE_EQ(limiter.targets()[0], 0.35);
}

TEST(JointLimiter, KeepsTheTargetOfAJointWhoseNewOneIsNotFinite) {
  JointLimiter limiter({JointLimits{}, JointLimits{}}, 0.01);
  limiter.reset(std::vector{0.0, 0.0});
  limiter.aim(std::vector{0.5, 0.5});
  limiter.aim(std::vector{kNaN, 0.7});
  limiter.aim(std::vector{-kInfinity, kInfinity});
  EXPECT_EQ(limiter.targets()[0], 0.5);
  EXPECT_EQ(limiter.targets()[1], 0.7);
}

TEST(JointLimiter, BrakesAsFastAsItMayAndHolds) {
  const Case c{{.lower = -5, .upper = 5, .velocity = 2, .acceleration = 10, .jerk = 200}, 0.01};
  JointLimiter limiter({c.limits}, c.period);
  limiter.reset(std::vector{0.0});
  limiter.aim(std::vector{4.0});
  Trace trace(0, c.period);
  for (int k = 0; k < 100; ++k)
    trace.add(limiter.step()[0]);
  limiter.brake();
  const double at_brake = trace.last();
  int steps = 0;
  while (!limiter.atRest() && ++steps < 1000)
    trace.add(limiter.step()[0]);
  const double held = trace.last();
  trace.add(limiter.step()[0]);
  expectWithin(trace, c.limits);
  EXPECT_EQ(trace.last(), held);
  // V^2 / (2 A) of braking, and what the average of 10 positions lags at full speed.
  EXPECT_NEAR(held - at_brake, 2.0 * 2.0 / (2 * 10) + 2.0 * 0.045, 0.02);
  EXPECT_LE(steps * c.period, 2.0 / 10 + 10 * c.period + c.period);
  EXPECT_EQ(limiter.targets()[0], 4.0) << "the target is kept for what comes next";
}

TEST(JointLimiter, MovesOnlyInwardsFromOutsideItsLimits) {
  const JointLimits limits{.lower = 0, .upper = 1};
  JointLimiter limiter({limits}, 0.01);
  limiter.reset(std::vector{1.4});
  EXPECT_EQ(limiter.step()[0], 1.4) << "a reset moves nothing";
  limiter.aim(std::vector{2.0});
  double before = 1.4;
  for (int k = 0; k < 500; ++k) {
    const double now = limiter.step()[0];
    EXPECT_LE(now, before);
    before = now;
  }
  EXPECT_EQ(before, 1 - limits.margin);
}

TEST(JointLimiter, StandsStillAfterAResetInMotion) {
  JointLimiter limiter({JointLimits{}}, 0.01);
  limiter.reset(std::vector{0.0});
  limiter.aim(std::vector{1.0});
  for (int k = 0; k < 30; ++k)
    limiter.step();
  limiter.reset(std::vector{0.25});
  for (int k = 0; k < 30; ++k)
    EXPECT_EQ(limiter.step()[0], 0.25);
}

TEST(JointLimiter, ReachesTargetsOfAJointWithoutLimits) {
  const Case c{{.velocity = 3, .acceleration = 30, .jerk = 600}, 0.01};
  EXPECT_EQ(runTo(c, 0, -40).last(), -40);
}

TEST(JointLimiter, SurvivesTheLargestTargets) {
  const JointLimits limits{.velocity = 3, .acceleration = 30, .jerk = 600};
  JointLimiter limiter({limits}, 0.01);
  limiter.reset(std::vector{0.0});
  Trace trace(0, 0.01);
  for (int k = 0; k < 400; ++k) {
    limiter.aim(std::vector{(k / 100) % 2 == 0 ? 1.7e308 : -1.7e308});
    trace.add(limiter.step()[0]);
  }
  expectWithin(trace, limits);
}

TEST(JointLimiter, MovesJointsAsIfEachWereAlone) {
  const JointLimits fast{.velocity = 3}, slow{.velocity = 0.1};
  JointLimiter both({fast, slow}, 0.01), alone({slow}, 0.01);
  both.reset(std::vector{0.0, 0.0});
  alone.reset(std::vector{0.0});
  both.aim(std::vector{1.0, 0.5});
  alone.aim(std::vector{0.5});
  for (int k = 0; k < 200; ++k)
    EXPECT_EQ(both.step()[1], alone.step()[0]);
}

TEST(JointLimiter, MovesAtAShareOfItsSpeedAndSlowsDownToIt) {
  const Case c{{.lower = -5, .upper = 5, .velocity = 2, .acceleration = 10, .jerk = 200}, 0.01};
  JointLimiter limiter({c.limits}, c.period);
  limiter.reset(std::vector{0.0});
  limiter.setSpeedShare(0.25);
  limiter.aim(std::vector{4.0});
  Trace slow(0, c.period);
  for (int k = 0; k < 100; ++k)
    slow.add(limiter.step()[0]);
  EXPECT_NEAR(slow.velocity, 0.5, 1e-9);

  Trace whole(0, c.period);
  limiter.reset(std::vector{0.0});
  limiter.aim(std::vector{4.0});
  limiter.setSpeedShare(1);
  for (int k = 0; k < 60; ++k)
    whole.add(limiter.step()[0]);
  EXPECT_NEAR(whole.velocity, 2, 1e-9);
  limiter.setSpeedShare(0.25);
  for (int k = 0; k < 40; ++k)
    whole.add(limiter.step()[0]);
  expectWithin(whole, c.limits);
  const double before = limiter.positions()[0];
  EXPECT_NEAR(limiter.step()[0] - before, 0.5 * c.period, 1e-9);
}

TEST(JointLimiter, LandsNoFasterThanItsShareOfSpeed) {
  // One period's acceleration is more than the share of speed: the last step is no shortcut.
  const Case c{{.velocity = 1, .acceleration = 80, .jerk = 1e6}, 0.01};
  JointLimiter limiter({c.limits}, c.period);
  limiter.reset(std::vector{0.0});
  limiter.setSpeedShare(0.1);
  limiter.aim(std::vector{0.0995});
  Trace trace(0, c.period);
  for (int k = 0; k < 200; ++k)
    trace.add(limiter.step()[0]);
  EXPECT_LE(trace.velocity, 0.1 * (1 + kRounding));
  EXPECT_EQ(trace.last(), 0.0995);
}

TEST(JointLimiter, TellsWhatHoldsJointsBack) {
  const JointLimits limits{.velocity = 2, .acceleration = 10, .jerk = 5000};
  JointLimiter limiter({limits, limits}, 0.01);
  limiter.reset(std::vector{0.0, 0.0});
  limiter.aim(std::vector{4.0, 0.0});
  limiter.step();
  EXPECT_EQ(limiter.activity().at_acceleration, 1u) << "the first joint speeds up";
  for (int k = 0; k < 50; ++k)
    limiter.step();
  EXPECT_EQ(limiter.activity().at_acceleration, 0u);
  EXPECT_EQ(limiter.activity().at_velocity, 1u);
  for (int k = 0; k < 500; ++k)
    limiter.step();
  EXPECT_EQ(limiter.activity().at_velocity, 0u) << "it has arrived";
}

TEST(JointLimiter, StandsStillWithinItsBrakingTime) {
  std::mt19937 random(11);
  for (const Case& c : manyCases(random, 30)) {
    JointLimiter limiter({c.limits}, c.period);
    limiter.reset(std::vector{c.limits.lower});
    limiter.aim(std::vector{c.limits.upper});
    for (int k = 0; k < 0.2 / c.period; ++k)
      limiter.step();
    limiter.brake();
    int steps = 0;
    while (!limiter.atRest() && steps < 100000) {
      limiter.step();
      ++steps;
    }
    EXPECT_LE(steps * c.period, limiter.brakingTime(0) + 2 * c.period);
  }
}

TEST(JointLimiter, RefusesLimitsThatMeanNothing) {
  const auto refuses = [](JointLimits limits, double period = 0.01) {
    EXPECT_THROW(JointLimiter({limits}, period), InvalidInput);
  };
  refuses({.lower = 1, .upper = 0});
  refuses({.lower = kNaN});
  refuses({.lower = kInfinity});
  refuses({.velocity = 0});
  refuses({.acceleration = -1});
  refuses({.jerk = kNaN});
  refuses({.velocity = kInfinity});
  refuses({.margin = -0.1});
  refuses({.jerk = 1e-9});
  refuses({}, 0);
  refuses({}, kNaN);
  refuses({}, 2);
}

TEST(JointLimiter, RefusesToStartAtAPositionThatIsNotFinite) {
  JointLimiter limiter({JointLimits{}, JointLimits{}}, 0.01);
  limiter.reset(std::vector{0.1, 0.2});
  EXPECT_THROW(limiter.reset(std::vector{0.3, kNaN}), InvalidInput);
  EXPECT_EQ(limiter.step()[0], 0.1) << "nothing changed";
  EXPECT_THROW(limiter.reset(std::vector{0.3}), BrokenContract);
}

TEST(JointLimiter, NeedsAResetBeforeTheFirstStep) {
  JointLimiter limiter({JointLimits{}}, 0.01);
  EXPECT_THROW(limiter.step(), BrokenContract);
}

}  // namespace
}  // namespace handgraft::safety
