// The governor's promise to the motors, over streams that do everything wrong.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/hardware/safety/governor_rig.h"
#include "tests/hardware/safety/ledger.h"

namespace handgraft::safety {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

GovernorOptions stormOptions(double period_s, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  GovernorOptions options = quickOptions();
  options.period_s = period_s;
  options.names.clear();
  options.limits.clear();
  for (int i = 0; i < 3; ++i) {
    options.names.push_back("joint_" + std::to_string(i));
    options.limits.push_back({.lower = -0.3 - unit(random),
                              .upper = 0.5 + unit(random),
                              .velocity = 0.3 + 2 * unit(random),
                              .acceleration = 10 + 60 * unit(random),
                              .jerk = 200 * std::pow(50, unit(random))});
  }
  options.brake_within = 3000ms;
  options.ramp_share = 0.5;
  options.step = {100, 1};  // slow steps would try no limit
  return options;
}

/// A stream of steps, reversals, noise, sines, pauses and rubbish.
class Storm {
 public:
  Storm(Rig& rig, std::uint64_t seed) : rig_(rig), random_(seed) {}

  void blow() {
    const double kind = unit();
    if (pause_ > 0) --pause_;
    if (kind < 0.003) {  // a step; one in two holds long enough to arrive
      for (double& q : pose_)
        q = 4 * unit() - 2;
    } else if (kind < 0.005) {
      for (double& q : pose_)
        q = -q;
    } else if (kind < 0.006) {
      pause_ = static_cast<int>(unit() * 40);
    } else if (kind < 0.0065) {
      noise_ = static_cast<int>(unit() * 200);
    }
    std::vector<double> pose = pose_;
    if (noise_ > 0) {
      --noise_;
      for (double& q : pose)
        q += 0.2 * (unit() - 0.5);
    }
    if (pause_ > 0) return;
    const double fault = unit();
    if (fault < 0.02) pose[0] = fault < 0.01 ? kNaN : kInfinity;
    if (fault > 0.02 && fault < 0.03) pose.pop_back();
    if (fault > 0.03 && fault < 0.04) pose.push_back(0);
    if (fault > 0.04 && fault < 0.05) pose.assign(3, fault < 0.045 ? 1e300 : -1e300);
    if (fault > 0.05 && fault < 0.06) --rig_.sequence;
    rig_.offer(pose);
  }

  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

 private:
  Rig& rig_;
  std::mt19937_64 random_;
  std::vector<double> pose_{0.1, 0.1, 0.1};
  int pause_ = 0;
  int noise_ = 0;
};

struct StormResult {
  std::vector<RequestDeduplication> joints;
  double overshoot = 0;
  int steps_from_rest = 0;
  long powered_ticks = 0;
  GovernorCounters counters;
};

StormResult weather(const GovernorOptions& options, std::uint64_t seed, int ticks) {
  Rig rig(options);
  Storm storm(rig, seed);
  std::mt19937_64 operator_dice(seed + 1);
  std::uniform_int_distribution<int> dice(0, 4999);
  StormResult result;
  std::vector<OvershootWatch> watches(3);
  for (const JointLimits& limits : options.limits)
    result.joints.emplace_back(limits, options.period_s);
  bool was_powered = false;
  for (int k = 0; k < ticks; ++k) {
    storm.blow();
    const int order = dice(operator_dice);
    if (order == 0) rig.governor.estop();
    if (order == 1) rig.governor.disarm();
    if (order == 2) rig.fault_code = 1;
    if (order > 4000) rig.governor.reset();
    if (order > 3000) rig.arm();
    for (int i = 0; i < 3; ++i) {
      const bool rests = result.joints[i].rests();
      watches[i].see(rig.governor.target()[i], rests, rig.position[i]);
      if (rig.state() != GovernorState::kArmed) watches[i].watches = false;
    }
    rig.tick();
    if (rig.power != Power::kOn) {
      was_powered = false;
      continue;
    }
    ++result.powered_ticks;
    for (int i = 0; i < 3; ++i) {
      if (!was_powered) result.joints[i].begin(rig.sent[i]);
      result.joints[i].add(rig.sent[i]);
      watches[i].sent(rig.sent[i]);
    }
    was_powered = true;
  }
  for (const OvershootWatch& watch : watches) {
    result.overshoot = std::max(result.overshoot, watch.worst);
    result.steps_from_rest += watch.steps;
  }
  result.counters = rig.governor.counters();
  return result;
}

TEST(GovernorStorm, NeverExceedsALimitInAMillionTicks) {
  long powered = 0;
  int steps = 0;
  std::array<std::uint64_t, static_cast<std::size_t>(SampleVerdict::kCount)> samples{};
  StormResult worst{};
  for (int run = 0; run < 10; ++run) {
    const double period = run % 3 == 0 ? 0.01 : run % 3 == 1 ? 0.005 : 0.002;
    const GovernorOptions options = stormOptions(period, 1000 + run);
    const StormResult result = weather(options, 20261121 + run, 110'000);
    for (std::size_t i = 0; i < 3; ++i) {
      const RequestDeduplication& joint = result.joints[i];
      EXPECT_LE(joint.velocity, kWithin);
      EXPECT_LE(joint.acceleration, kWithin);
      EXPECT_LE(joint.jerk, kWithin);
      EXPECT_GE(joint.lowest, options.limits[i].lower);
      EXPECT_LE(joint.highest, options.limits[i].upper);
      EXPECT_GT(joint.velocity, 0.8) << "the joint was hardly tried";
    }
    EXPECT_LE(result.overshoot, kOvershoot);
    worst.overshoot = std::max(worst.overshoot, result.overshoot);
    powered += result.powered_ticks;
    steps += result.steps_from_rest;
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] += result.counters.samples[i];
    EXPECT_EQ(result.counters.faults[static_cast<std::size_t>(FaultCause::kOutput)], 0u);
    EXPECT_GT(result.counters.emergency_stops, 3u);
    EXPECT_GT(result.counters.stale_streams, 3u);
  }
  EXPECT_GE(powered, 1'000'000) << "ticks under power";
  EXPECT_GT(steps, 1000) << "steps from rest";
  for (const SampleVerdict verdict : {SampleVerdict::kAccepted, SampleVerdict::kNotFinite,
                                      SampleVerdict::kWrongLength, SampleVerdict::kRepeated})
    EXPECT_GT(samples[static_cast<std::size_t>(verdict)], 1000u) << toString(verdict);
  RecordProperty("overshoot_rad", std::to_string(worst.overshoot));
  RecordProperty("powered_ticks", std::to_string(powered));
}

TEST(GovernorStorm, EqualStormsGiveEqualBytes) {
  const GovernorOptions options = stormOptions(0.01, 5);
  const StormResult a = weather(options, 77, 5000), b = weather(options, 77, 5000);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a.joints[i].lowest, b.joints[i].lowest);
    EXPECT_EQ(a.joints[i].jerk, b.joints[i].jerk);
  }
}

TEST(GovernorStorm, TheLedgerSeesWhatAJumpIs) {
  RequestDeduplication ledger({.velocity = 1, .acceleration = 10, .jerk = 100}, 0.01);
  ledger.begin(0);
  ledger.add(0.02);
  EXPECT_NEAR(ledger.velocity, 2, 1e-12);
  EXPECT_NEAR(ledger.acceleration, 20, 1e-9);
  EXPECT_NEAR(ledger.jerk, 200, 1e-9);
}

}  // namespace
}  // namespace handgraft::safety
