#include "hardware/safety/homing_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::safety {
namespace {

using namespace std::chrono_literals;
using State = HomingRun::State;

constexpr double kPeriod = 0.01;

HomingStep usualStep() {
  HomingStep step;
  step.toward = 1;
  step.speed_rad_s = 0.5;
  step.current_A = 0.3;
  step.hold = 200ms;
  step.travel_rad = 3;
  step.stop_rad = 0.25;
  step.back_off_rad = 0.1;
  return step;
}

/// A position servo before a hard stop: its current grows with how far it lags.
struct Servo {
  double position = 0;
  double stop = 1e9;  ///< in the direction `toward`
  int toward = 1;
  double current = 0;
  double highest_current = 0;

  void follow(double target) {
    position = toward * std::min(toward * target, stop);
    current = 4 * (target - position);  // A/rad
    highest_current = std::max(highest_current, std::abs(current));
  }
};

struct Finished {
  State state;
  std::optional<double> zero;
  std::vector<double> sent;
};

Finished runOn(Servo& servo, const HomingStep& step) {
  Time now{1h};
  HomingRun run(step, kPeriod, servo.position, now);
  Finished finished{};
  for (int k = 0; k < 20000; ++k) {
    now += 10ms;
    const double sent = run.tick(servo.position, servo.current, now);
    finished.sent.push_back(sent);
    servo.follow(sent);
    if (run.state() == State::kDone || run.state() == State::kFailed) break;
  }
  finished.state = run.state();
  finished.zero = run.zero();
  return finished;
}

TEST(HomingRun, FindsTheStopAndBacksOff) {
  for (const int toward : {1, -1}) {
    HomingStep step = usualStep();
    step.toward = toward;
    Servo servo{.stop = 1.1, .toward = toward};
    const Finished finished = runOn(servo, step);
    EXPECT_EQ(finished.state, State::kDone);
    ASSERT_TRUE(finished.zero);
    EXPECT_NEAR(*finished.zero, toward * 1.1 - 0.25, 1e-12);
    EXPECT_NEAR(servo.position, toward * (1.1 - 0.1), 1e-12);
  }
}

TEST(HomingRun, PressesNoHarderThanItTakesToBrake) {
  Servo servo{.stop = 1.1};
  runOn(servo, usualStep());
  // 0.3 A, and the way of braking from 0.5 rad/s at 5 rad/s^2 with its average: 4 A/rad.
  EXPECT_LE(servo.highest_current, 0.3 + 4 * (0.5 * 0.5 / (2 * 5) + 0.5 * 0.06));
}

TEST(HomingRun, SendsNothingFasterThanItsSpeed) {
  Servo servo{.stop = 1.1};
  const Finished finished = runOn(servo, usualStep());
  for (std::size_t k = 1; k < finished.sent.size(); ++k)
    EXPECT_LE(std::abs(finished.sent[k] - finished.sent[k - 1]), 0.5 * kPeriod * (1 + 1e-9));
}

TEST(HomingRun, FailsWithinItsTravelWhenNothingHoldsItBack) {
  Servo servo;
  const Finished finished = runOn(servo, usualStep());
  EXPECT_EQ(finished.state, State::kFailed);
  EXPECT_FALSE(finished.zero);
  EXPECT_LE(*std::max_element(finished.sent.begin(), finished.sent.end()), 3.0);
}

TEST(HomingRun, GoesOnAfterAMomentOfFriction) {
  const HomingStep step = usualStep();
  Time now{1h};
  HomingRun run(step, kPeriod, 0, now);
  Servo servo{.stop = 1.1};
  for (int k = 0; k < 3000 && run.state() != State::kDone; ++k) {
    now += 10ms;
    const bool sticks = k > 30 && k < 45;
    servo.follow(run.tick(servo.position, sticks ? 0.5 : servo.current, now));
  }
  EXPECT_EQ(run.state(), State::kDone);
  EXPECT_NEAR(*run.zero(), 1.1 - 0.25, 1e-12);
}

TEST(HomingRun, TakesAMotorThatCreepsForNoStop) {
  const HomingStep step = usualStep();
  Time now{1h};
  HomingRun run(step, kPeriod, 0, now);
  double position = 0;
  for (int k = 0; k < 500; ++k) {
    now += 10ms;
    position += 0.4 * kPeriod;  // it moves at most of its speed, under load
    run.tick(position, 0.5, now);
    ASSERT_FALSE(run.zero());
  }
}

TEST(HomingRun, FailsOnMeasurementsThatAreNoneAndKeepsItsPlace) {
  for (const bool bad_position : {true, false}) {
    Time now{1h};
    HomingRun run(usualStep(), kPeriod, 0, now);
    for (int k = 0; k < 50; ++k)
      run.tick(0, 0, now += 10ms);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    run.tick(bad_position ? nan : 0, bad_position ? 0 : nan, now += 10ms);
    EXPECT_EQ(run.state(), State::kFailed);
    double last = 0;
    for (int k = 0; k < 50; ++k)
      last = run.tick(0, 0, now += 10ms);
    EXPECT_EQ(run.tick(0, 0, now += 10ms), last);
  }
}

TEST(HomingRun, FailsWhenItTakesTooLong) {
  // Current comes and goes, so that it never settles.
  Time now{1h};
  HomingRun run(usualStep(), kPeriod, 0, now);
  int k = 0;
  while (run.state() != State::kFailed && k < 10000) {
    run.tick(0, (k / 10) % 2 == 0 ? 0.5 : 0, now += 10ms);
    ++k;
  }
  EXPECT_LE(k * kPeriod, 2 * 3 / 0.5 + 1 + 0.4 + 0.02);
}

TEST(HomingRun, RefusesStepsThatMeanNothing) {
  const auto refuses = [](auto spoil) {
    HomingStep step = usualStep();
    spoil(step);
    EXPECT_THROW(HomingRun(step, kPeriod, 0, Time{}), InvalidInput);
  };
  refuses([](HomingStep& s) {
    s.toward = 0;
  });
  refuses([](HomingStep& s) {
    s.speed_rad_s = 0;
  });
  refuses([](HomingStep& s) {
    s.current_A = -1;
  });
  refuses([](HomingStep& s) {
    s.travel_rad = std::nan("");
  });
  refuses([](HomingStep& s) {
    s.hold = 0ms;
  });
  refuses([](HomingStep& s) {
    s.back_off_rad = -1;
  });
}

}  // namespace
}  // namespace handgraft::safety
