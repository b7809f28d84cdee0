// Timed samples in a time of the test's own.

#include "hardware/bridge/sample_path.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using safety::SampleVerdict;
using safety::Time;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr double kPeriod = 0.005;  // s
constexpr double kRate = 120;      // Hz
constexpr double kAnyRate = std::numeric_limits<double>::infinity();
constexpr std::int64_t kSenderBeginNs = 1'700'000'000'000'000'000;  // another clock's

/// A joint that swings: at 1 rad/s at most.
double swing(double time_s) {
  return 0.5 * std::sin(2.0 * time_s);
}

struct Sender {
  SamplePath path{1};
  Time begin{std::chrono::hours(1)};
  double worst_step = 0;  // of the pose in one period
  double worst_off = 0;   // of the pose against the swing, delay aside
  std::vector<double> last;

  [[nodiscard]] Time at(double time_s) const {
    return begin + microseconds(std::llround(1e6 * time_s));
  }

  SampleVerdict send(double sample_s, double arrives_s, double value) {
    return path.add(kSenderBeginNs + std::llround(1e9 * sample_s), std::vector{value}, false,
                    at(arrives_s));
  }

  void advance(double now_s, double most_rate = kAnyRate) {
    const auto pose = path.advance(at(now_s), most_rate);
    if (pose.empty()) return;
    if (!last.empty()) worst_step = std::max(worst_step, std::abs(pose[0] - last[0]));
    last.assign(pose.begin(), pose.end());
  }

  /// Sends the swing from `from_s` on while `wanted(k)`, and goes along period by period.
  template <class Wanted, class Late>
  void stream(double from_s, double to_s, Wanted wanted, Late late) {
    int sample = static_cast<int>(std::ceil(from_s * kRate));
    for (double now = from_s; now < to_s; now += kPeriod) {
      for (; sample / kRate + late(sample) <= now; ++sample) {
        const double time = sample / kRate;
        if (wanted(sample)) send(time, time + late(sample), swing(time));
      }
      advance(now);
      if (now > from_s + 0.5 && !last.empty())
        worst_off = std::max(worst_off, std::abs(last[0] - swing(now - 1 / kRate)));
    }
  }
};

const auto every_sample = [](int) {
  return true;
};
const auto in_time = [](int) {
  return 0.0;
};

TEST(SamplePath, GoesAlongSamplesOneIntervalBehind) {
  Sender sender;
  EXPECT_TRUE(sender.path.advance(sender.at(0), kAnyRate).empty());
  sender.stream(0, 4, every_sample, in_time);
  // A share of a period of delay, at 1 rad/s.
  EXPECT_LT(sender.worst_off, 0.003);
  EXPECT_LT(sender.worst_step, 1.2 * kPeriod);
}

TEST(SamplePath, BearsALossOfOneInTen) {
  Sender sender;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> chance(0, 1);
  sender.stream(
      0, 20,
      [&](int) {
        return chance(random) > 0.1;
      },
      in_time);
  EXPECT_LT(sender.worst_step, 2 * kPeriod);  // a little faster after each
  EXPECT_LT(sender.worst_off, 0.05);
  EXPECT_EQ(sender.path.skipped(), 0u);
}

TEST(SamplePath, LearnsHowLateSamplesCome) {
  Sender sender;
  std::mt19937 random(3);
  std::vector<double> late(4000);
  for (double& each : late)
    each = std::uniform_real_distribution<double>(0.02, 0.025)(random);
  sender.stream(0, 10, every_sample, [&](int sample) {
    return late[static_cast<std::size_t>(sample)];
  });
  EXPECT_LT(sender.worst_step, 1.6 * kPeriod);
  EXPECT_LT(sender.worst_off, 0.03);
}

TEST(SamplePath, SamplesOutOfOrderTakeTheirPlaceOrAreLate) {
  Sender sender;
  sender.send(0.00, 0.000, 0.0);
  sender.send(0.02, 0.001, 0.2);
  EXPECT_EQ(sender.send(0.01, 0.002, 0.5), SampleVerdict::kAccepted);
  EXPECT_EQ(sender.send(0.01, 0.003, 0.9), SampleVerdict::kRepeated);
  double highest = 0;
  for (double now = 0; now < 0.2; now += kPeriod) {
    sender.advance(now);
    highest = std::max(highest, sender.last[0]);
  }
  EXPECT_NEAR(highest, 0.5, 0.15) << "the sample in between was passed";
  EXPECT_EQ(sender.last[0], 0.2);
  EXPECT_EQ(sender.send(0.015, 0.2, 0.9), SampleVerdict::kLate);
}

TEST(SamplePath, WhatIsNoPoseChangesNothing) {
  Sender sender;
  sender.send(0, 0, 0.1);
  sender.send(0.01, 0.01, 0.2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(sender.send(0.02, 0.02, nan), SampleVerdict::kNotFinite);
  EXPECT_EQ(sender.path.add(kSenderBeginNs, std::vector{0.1, 0.2}, false, sender.at(0.02)),
            SampleVerdict::kWrongLength);
  EXPECT_EQ(sender.send(-5, 0.02, 0.7), SampleVerdict::kBackwards);
  for (double now = 0.02; now < 0.1; now += kPeriod)
    sender.advance(now);
  EXPECT_EQ(sender.last[0], 0.2);
}

TEST(SamplePath, HoldsWhileNothingComesAndGoesOnWithoutAStep) {
  Sender sender;
  sender.stream(0, 2, every_sample, in_time);
  const double held = sender.last[0];
  for (double now = 2; now < 2.15; now += kPeriod)
    sender.advance(now);
  EXPECT_NEAR(sender.last[0], held, 0.02);
  // 150 ms were lost; then it goes on.
  sender.stream(2.15, 4, every_sample, in_time);
  EXPECT_LT(sender.worst_step, 2 * kPeriod);
  EXPECT_NEAR(sender.last[0], swing(4 - 1 / kRate), 0.02);
}

TEST(SamplePath, AfterASilenceTimeMayBeAnother) {
  Sender sender;
  sender.stream(0, 1, every_sample, in_time);
  EXPECT_TRUE(sender.path.isPlaying(sender.at(1.1)));
  for (double now = 1; now < 2; now += kPeriod)
    sender.advance(now);
  EXPECT_FALSE(sender.path.isPlaying(sender.at(2)));
  // The sender sought back; its clock too.
  EXPECT_EQ(sender.send(-3, 2.0, 0.3), SampleVerdict::kAccepted);
  for (double now = 2.0; now < 2.1; now += kPeriod)
    sender.advance(now);
  EXPECT_EQ(sender.last[0], 0.3);
  EXPECT_EQ(sender.path.skipped(), 0u);
}

TEST(SamplePath, IsFollowedSlowerWhereNoMoreIsPermittedAndCatchesUp) {
  Sender sender;
  for (int k = 0; k <= 120; ++k)
    sender.send(k / kRate, 0, 2.0 * k / kRate);  // 2 rad/s for 1 s, sent at once
  double now = 0;
  for (; now < 1; now += kPeriod)
    sender.advance(now, 0.5);
  EXPECT_NEAR(sender.last[0], 1.0, 0.05);
  EXPECT_NEAR(sender.path.behind(), 0.5, 0.05);
  EXPECT_NEAR(sender.path.velocity()[0], 2.0, 1e-6);
  for (; now < 2.2; now += kPeriod)
    sender.advance(now);
  EXPECT_EQ(sender.last[0], 2.0);
  EXPECT_EQ(sender.path.skipped(), 0u);
  EXPECT_LT(sender.worst_step, 1.6 * 2.0 * kPeriod);
}

TEST(SamplePath, WhatIsASecondBehindIsPassedOver) {
  Sender sender;
  int sample = 0;
  for (double now = 0; now < 5; now += kPeriod) {
    for (; sample / kRate <= now; ++sample)
      sender.send(sample / kRate, now, 0.1 * sample / kRate);
    sender.advance(now, 0.2);
    EXPECT_LE(sender.path.behind(), 1.01);
  }
  EXPECT_GT(sender.path.skipped(), 0u);
}

TEST(SamplePath, AWholeTrajectoryInOneMessageIsFollowedInItsTime) {
  Sender sender;
  const auto add = [&](double time, double value, bool continues) {
    return sender.path.add(kSenderBeginNs + std::llround(1e9 * time), std::vector{value},
                           continues, sender.at(0));
  };
  EXPECT_EQ(add(0, 0, false), SampleVerdict::kAccepted);
  EXPECT_EQ(add(2, 1, true), SampleVerdict::kAccepted);  // sparse, as waypoints are
  EXPECT_EQ(add(3, 0, true), SampleVerdict::kAccepted);
  for (double now = 0; now < 1.01; now += kPeriod)
    sender.advance(now);
  EXPECT_NEAR(sender.last[0], 0.5, 0.02);
  for (double now = 1.01; now < 3.1; now += kPeriod)
    sender.advance(now);
  EXPECT_EQ(sender.last[0], 0.0);
  EXPECT_LT(sender.worst_step, 1.6 * kPeriod);
}

TEST(SamplePath, KeepsTheNewestOfTooMany) {
  Sender sender;
  const int many = static_cast<int>(SamplePath::kMostSamples) + 100;
  for (int k = 0; k < many; ++k)
    ASSERT_EQ(sender.path.add(kSenderBeginNs + std::int64_t{1'000'000} * k,
                              std::vector{1.0 * k}, k > 0, sender.at(0)),
              SampleVerdict::kAccepted);
  EXPECT_EQ(sender.path.skipped(), 100u);
}

}  // namespace
}  // namespace handgraft::bridge
