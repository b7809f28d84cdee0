// A hand that is guided by timed samples, on an emulated device and in virtual time: what comes
// over a network, and what leaves for the motors.

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/hardware/bridge/every_hand_in_motion.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using test::exampleReady;
using test::HandInMotion;

constexpr double kRate = 120;  // Hz

class GuidedHand : public ::testing::Test {
 protected:
  GuidedHand() : hand(exampleReady("leap")) {
    for (const safety::JointLimits& limits : hand.motion().config().governor.limits) {
      middle.push_back((limits.lower + limits.upper) / 2);
      half.push_back((limits.upper - limits.lower) / 2);
    }
  }

  /// All joints swing by a tenth of their range.
  [[nodiscard]] std::vector<double> swing(double time_s, double speed = 1.0) const {
    std::vector<double> pose = middle;
    for (std::size_t i = 0; i < pose.size(); ++i)
      pose[i] += 0.1 * half[i] * std::sin(speed * time_s);
    return pose;
  }

  void send(double sample_s, std::vector<double> pose) {
    TimedPose sample;
    sample.stream = hand.stream;
    sample.source_ns = 1'700'000'000'000'000'000 + std::llround(1e9 * sample_s);
    sample.arrived = hand.now();
    sample.joint_rad = std::move(pose);
    hand.motion().offer(sample);
  }

  double time() { return std::chrono::duration<double>(hand.now().time_since_epoch()).count(); }

  /// `passes(k, t)`: sends what it likes in place of sample k of time t.
  void streamFor(double seconds, const std::function<void(int, double)>& passes) {
    const double end = time() + seconds;
    for (auto k = static_cast<int>(std::ceil(time() * kRate)); time() < end;) {
      for (; k / kRate <= time(); ++k)
        passes(k, k / kRate);
      turn();
    }
  }

  void turn() {
    const std::vector<double> before = hand.state().command;
    hand.turn();
    if (!hand.state().is_powered) return;
    const config::HandConfig& config = hand.motion().config();
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double step = std::abs(hand.state().command[i] - before[i]);
      const double most = config.governor.limits[i].velocity * config.governor.period_s;
      worst_share = std::max(worst_share, step / most);
    }
  }

  /// Under power, at the beginning of the swing.
  bool start() {
    if (!hand.turnUntil(GovernorState::kIdle)) return false;
    hand.offer(swing(time()));
    hand.motion().request(Request::kArm);
    for (int i = 0; i < 300 && !hand.state().is_powered; ++i)
      hand.turn();
    streamFor(8, [&](int, double t) {
      send(t, swing(t));
    });
    worst_share = 0;
    return hand.state().state == GovernorState::kArmed && !hand.state().is_slow;
  }

  /// The largest |commanded - swing| now, delays of the limiter included.
  double off() {
    const std::vector<double> wanted = swing(time());
    return test::largestDifference(wanted, hand.state().command);
  }

  HandInMotion hand;
  std::vector<double> middle, half;
  double worst_share = 0;  // of a joint's step within a period, of what its speed permits
};

TEST_F(GuidedHand, GoesAlongTheSamples) {
  ASSERT_TRUE(start()) << describe(hand.state());
  EXPECT_TRUE(hand.state().is_guided);
  double worst = 0;
  streamFor(5, [&](int, double t) {
    send(t, swing(t));
    worst = std::max(worst, off());
  });
  EXPECT_LT(worst, 0.03);
  EXPECT_EQ(describe(hand.state()), "armed");
  EXPECT_EQ(hand.state().poses_refused, 0u);
}

TEST_F(GuidedHand, IsSmoothThoughOneSampleInTenIsLostAndOthersAreWrong) {
  ASSERT_TRUE(start()) << describe(hand.state());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> chance(0, 1);
  const std::vector<double> nothing(middle.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> wild = middle;
  for (std::size_t i = 0; i < wild.size(); ++i)
    wild[i] += half[i];
  double worst = 0;
  std::optional<double> late;
  streamFor(20, [&](int k, double t) {
    const double luck = chance(random);
    if (luck < 0.1) return;                               // lost
    if (luck < 0.15) return send(t, nothing);             // NaN
    if (luck < 0.2) return send(t - 30, wild);            // time runs backwards
    if (luck < 0.25) return static_cast<void>(late = t);  // comes after the next one
    send(t, swing(t));
    if (late) send(*std::exchange(late, std::nullopt), swing(*late));
    if (k % 7 == 0) send(t, wild);  // the same time again
    worst = std::max(worst, off());
  });
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(worst_share, 0.6);
  EXPECT_GT(hand.state().poses_refused, 0u);
  EXPECT_EQ(hand.state().samples_skipped, 0u);
}

TEST_F(GuidedHand, StandsUnderPowerWhileTheSenderPausesAndGoesOn) {
  ASSERT_TRUE(start()) << describe(hand.state());
  const double paused_at = time();
  hand.turnFor(1);
  const std::vector<double> held = hand.state().command;
  hand.turnFor(5);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
  EXPECT_EQ(hand.state().command, held);
  EXPECT_FALSE(hand.state().is_guided);
  // The sender's clock stood meanwhile.
  const double pause = time() - paused_at;
  streamFor(3, [&](int, double t) {
    send(t - pause, swing(t - pause));
  });
  EXPECT_LT(worst_share, 0.6);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed);
  EXPECT_LT(test::largestDifference(hand.state().command, swing(time() - pause)), 0.03);
}

TEST_F(GuidedHand, HoldsAndGoesOffWhenItsStreamDies) {
  ASSERT_TRUE(start()) << describe(hand.state());
  hand.is_streaming = false;
  EXPECT_TRUE(hand.turnUntil(GovernorState::kHolding, 2)) << describe(hand.state());
  EXPECT_TRUE(hand.turnUntil(GovernorState::kIdle, 5)) << describe(hand.state());
  EXPECT_LE(worst_share, 1.0 + 1e-6);
}

TEST_F(GuidedHand, StopsMidWayForGoodAndIsNotMovedBySamples) {
  ASSERT_TRUE(start()) << describe(hand.state());
  hand.motion().estop();
  const auto goes_on = [&](int, double t) {
    send(t, swing(t, 3.0));
  };
  streamFor(2, goes_on);
  EXPECT_EQ(hand.state().state, GovernorState::kEStop);
  EXPECT_FALSE(hand.state().is_powered);
  const std::vector<double> stood = hand.angles();
  streamFor(1, goes_on);
  EXPECT_LT(test::largestDifference(stood, hand.angles()), 1e-9);
  // RESET gives no power; ARM goes on slowly to where the samples are.
  hand.motion().request(Request::kReset);
  streamFor(1, goes_on);
  EXPECT_FALSE(hand.state().is_powered);
  hand.motion().request(Request::kArm);
  streamFor(1, goes_on);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
}

TEST_F(GuidedHand, IsSlowerThanSamplesThatAskForTooMuchAndSaysWhy) {
  ASSERT_TRUE(start()) << describe(hand.state());
  const auto fast = [&](double t) {
    std::vector<double> pose = middle;
    const double velocity = hand.motion().config().governor.limits[2].velocity;
    const double phase = std::fmod(t, 2.0);
    pose[2] += 0.8 * half[2] * (phase < 1 ? 2 * phase - 1 : 3 - 2 * phase);
    // The faster swing asks for twice what the joint may do.
    const double wanted = 1.6 * half[2];
    return std::pair(pose, wanted > velocity);
  };
  const double begin = time();
  const double velocity = hand.motion().config().governor.limits[2].velocity;
  const double speed = 2 * velocity / (1.6 * half[2]);  // swings a second
  bool is_told = false;
  streamFor(1.5, [&](int, double t) {
    send(t, fast(speed * (t - begin)).first);
    is_told =
        is_told || describe(hand.state())
                           .find("slower than its samples ask for: joint '" +
                                 hand.motion().config().governor.names[2]) != std::string::npos;
  });
  EXPECT_TRUE(is_told) << describe(hand.state());
  EXPECT_LE(worst_share, 1.0 + 1e-6);
  EXPECT_EQ(hand.state().state, GovernorState::kArmed) << describe(hand.state());
}

TEST_F(GuidedHand, PosesOfTheStreamWaitUntilTheSamplesHavePaused) {
  ASSERT_TRUE(start()) << describe(hand.state());
  const std::vector<double> target = hand.state().target;
  hand.offer(0.9);
  turn();
  EXPECT_LT(test::largestDifference(hand.state().target, target), 0.05);
  hand.turnFor(1);
  hand.offer(0.9);
  turn();
  EXPECT_GT(test::largestDifference(hand.state().target, target), 0.1);
}

TEST_F(GuidedHand, SamplesOfAnotherStreamChangeNothing) {
  ASSERT_TRUE(start()) << describe(hand.state());
  const std::uint64_t accepted = hand.state().poses_accepted;
  hand.stream = 2;
  send(time(), middle);
  EXPECT_EQ(hand.state().poses_accepted, accepted);
  EXPECT_EQ(hand.state().poses_refused, 0u);
}

}  // namespace
}  // namespace handgraft::bridge
