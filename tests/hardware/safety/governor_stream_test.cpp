// Which poses count, and what becomes of an armed hand without them.

#include <limits>

#include <gtest/gtest.h>

#include "hardware/safety/governor.h"

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

// A tenth of a metre would be the whole way of a jaw.
TEST(Governor, OfAJointThatSlidesNearAndFarAreMillimetres) {
  GovernorOptions options = quickOptions();
  options.limits[0] = {.lower = 0,
                       .upper = 0.04,
                       .velocity = 0.02,
                       .acceleration = 1,
                       .jerk = 100,
                       .margin = 1e-6,
                       .slides = true,
                       .travel = 3.2e-4};  // a screw's
  Rig rig(options);
  rig.position = {0.02, 0.05};
  rig.pose = {0.0195, 0.05};
  rig.armUp();
  ASSERT_EQ(rig.state(), State::kArmed);
  EXPECT_FALSE(rig.governor.isRamping()) << "half a millimetre is near";
  rig.offer({0.024, 0.05});
  rig.tick();
  EXPECT_FALSE(rig.governor.isRamping()) << "4.5 mm are a step";
  rig.follow(60);
  rig.offer({0.032, 0.05});
  rig.tick();
  EXPECT_TRUE(rig.governor.isRamping()) << "8 mm are a long one";

  Rig far(options);
  far.position = {0.015, 0.05};
  far.pose = {0.02, 0.05};
  far.armUp();
  EXPECT_TRUE(far.governor.isRamping()) << "5 mm from the first pose";

  Rig outside(options);
  outside.position = {0.0415, 0.05};
  outside.pose = {0.04, 0.05};
  outside.tick();
  outside.offer();
  EXPECT_EQ(outside.arm(), Refusal::kNone);
  Rig broken(options);
  broken.position = {0.0425, 0.05};
  broken.pose = {0.04, 0.05};
  broken.tick();
  broken.offer();
  EXPECT_EQ(broken.arm(), Refusal::kOutOfRange) << "2.5 mm past its stop";
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

}  // namespace
}  // namespace handgraft::safety
