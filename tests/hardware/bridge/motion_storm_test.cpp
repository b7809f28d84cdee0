// The promise to the motors over the whole way: streams that do everything wrong go in, and
// what the emulated devices decode from their wires is held against every limit.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/base/sanitized.h"

#include "tests/hardware/bridge/hand_in_motion.h"
#include "tests/hardware/config/config_texts.h"
#include "tests/hardware/safety/ledger.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using safety::test::kOvershoot;
using safety::test::kWithin;
using safety::test::OvershootWatch;
using safety::test::RequestDeduplication;
using test::HandInMotion;

// A million over the five hands, without those that have no power. Sanitizers look for
// something else, and are ten times slower.
constexpr int kTicks = kIsSanitized ? 23'000 : 230'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Steps, reversals, noise, rubbish and dropouts of a stream; an operator who arms, disarms,
/// stops and resets.
class Storm {
 public:
  Storm(HandInMotion& hand, std::uint64_t seed) : hand_(hand), random_(seed) {
    for (const safety::JointLimits& limits : hand.motion().config().governor.limits) {
      lower_.push_back(limits.lower);
      range_.push_back(limits.upper - limits.lower);
    }
    pose_ = anywhere();
  }

  void blow() {
    stream();
    operate();
  }

 private:
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  std::vector<double> anywhere() {
    std::vector<double> pose;
    for (std::size_t i = 0; i < lower_.size(); ++i)
      pose.push_back(lower_[i] + (2 * unit() - 0.5) * range_[i]);
    return pose;
  }

  void stream() {
    const double kind = unit();
    if (kind < 0.005) pose_ = anywhere();
    if (kind > 0.005 && kind < 0.008) {
      for (std::size_t i = 0; i < pose_.size(); ++i)
        pose_[i] = 2 * lower_[i] + range_[i] - pose_[i];
    }
    if (kind > 0.008 && kind < 0.009) noise_ = static_cast<int>(200 * unit());
    if (kind > 0.009 && kind < 0.0095) pause_ = static_cast<int>(30 * unit());
    hand_.is_streaming = pause_ == 0;
    if (pause_ > 0) {
      --pause_;
      return;
    }
    std::vector<double> pose = pose_;
    for (std::size_t i = 0; noise_ > 0 && i < pose.size(); ++i)
      pose[i] += 0.1 * (unit() - 0.5);
    noise_ = std::max(0, noise_ - 1);
    const double fault = unit();
    if (fault < 0.01)
      pose[pose.size() / 2] = fault < 0.005 ? kNaN : -std::numeric_limits<double>::infinity();
    if (fault > 0.01 && fault < 0.015) pose.pop_back();
    if (fault > 0.015 && fault < 0.02) pose.push_back(0);
    if (fault > 0.02 && fault < 0.03) pose.assign(pose.size(), fault < 0.025 ? 1e300 : -1e300);
    const bool is_new = fault < 0.03 || fault > 0.04;
    if (kind < 0.3 || noise_ > 0 || fault < 0.04) hand_.offer(std::move(pose), is_new);
  }

  void operate() {
    const int order = static_cast<int>(5000 * unit());
    if (order == 0) hand_.motion().estop();
    if (order == 1) hand_.motion().request(Request::kDisarm);
    if (order > 4600) hand_.motion().request(Request::kReset);
    if (order > 2000 && order < 4000) hand_.motion().request(Request::kArm);
  }

  HandInMotion& hand_;
  std::mt19937_64 random_;
  std::vector<double> lower_, range_, pose_;
  int pause_ = 0;
  int noise_ = 0;
};

/// Holds what each motor decoded from the wire against what left for it; of a motor that is
/// told torques, where it is against its range.
class WireWatch {
 public:
  explicit WireWatch(const config::HandConfig& config)
      : config_(config),
        map_(config::makeMotorMap(config)),
        motors_(config.motors.size()),
        residual_(config.jointCount()) {}

  void begin() {
    is_faded_ = false;
    within_ = 0;
  }

  /// A frame that was sent under power, after the one with which power came.
  void see(HandInMotion& hand) {
    map_->command(hand.state().command, motors_, residual_);
    double units = 0;
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      const double goal = is_torque_driven_ ? hand.rig().angle(i) : hand.rig().goal(i);
      if (!is_torque_driven_)
        units = std::max(units, std::abs(goal - motors_[i]) / hand.rig().unit(i));
      outside = std::max({outside, config_.motors[i].range_rad.lower - goal,
                          goal - config_.motors[i].range_rad.upper});
    }
    // Where the motors stood at first fades, and once it has, never comes back.
    within_ = units <= 1 ? within_ + 1 : 0;
    is_faded_ = is_faded_ || within_ > kFaded;
    if (!is_faded_) return;
    ++frames;
    worst_units = std::max(worst_units, units);
  }

  long frames = 0;
  double worst_units = 0;
  double outside = -std::numeric_limits<double>::infinity();  ///< rad beyond a motor's range

 private:
  static constexpr int kFaded = 20;  // frames: rounding alone keeps none that long within

  config::HandConfig config_;
  bool is_torque_driven_ = config_.device.kind == config::DeviceKind::kAllegro;
  std::unique_ptr<tendon::MotorMap> map_;
  std::vector<double> motors_, residual_;
  bool is_faded_ = false;
  int within_ = 0;
};

class EveryHandInAStorm : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryHandInAStorm, KeepsEveryLimitAndTheDeviceDecodesIt) {
  config::HandConfig config = test::exampleConfig(GetParam());
  config.homing.clear();            // as if it had been homed
  config.governor.step = {100, 1};  // slow steps would try no limit
  config.governor.stale_after = std::chrono::milliseconds(100);
  config.governor.period_s = std::max(config.governor.period_s, 0.01);  // as the storm blows
  const std::vector<safety::JointLimits>& limits = config.governor.limits;
  HandInMotion hand(config);
  Storm storm(hand, 20261121);
  WireWatch wire(config);
  std::vector<RequestDeduplication> joints;
  for (const safety::JointLimits& limit : limits)
    joints.emplace_back(limit, config.governor.period_s);
  std::vector<OvershootWatch> watches(limits.size());
  long powered = 0;
  long stops = 0, holds = 0;
  bool was_powered = false;
  GovernorState before = GovernorState::kDisconnected;
  std::vector<double> last = hand.state().command;
  for (int k = 0; k < kTicks; ++k) {
    storm.blow();
    hand.turn();
    const MotionState& state = hand.state();
    ASSERT_NE(state.state, GovernorState::kFault) << describe(state) << " at tick " << k;
    stops += state.state == GovernorState::kEStop && before != state.state ? 1 : 0;
    holds += state.state == GovernorState::kHolding && before != state.state ? 1 : 0;
    before = state.state;
    for (std::size_t i = 0; state.is_powered && i < joints.size(); ++i) {
      if (was_powered) {
        watches[i].see(state.target[i], joints[i].rests(), last[i]);
        watches[i].watches = watches[i].watches && state.state == GovernorState::kArmed;
        joints[i].add(state.command[i]);
        watches[i].sent(state.command[i]);
      } else {
        joints[i].begin(state.command[i]);
        watches[i].watches = false;
      }
    }
    if (state.is_powered && was_powered) wire.see(hand);
    if (!state.is_powered) wire.begin();
    powered += state.is_powered ? 1 : 0;
    was_powered = state.is_powered;
    last = state.command;
  }

  double overshoot = 0;
  int steps = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    EXPECT_LE(joints[i].velocity, kWithin) << i;
    EXPECT_LE(joints[i].acceleration, kWithin) << i;
    EXPECT_LE(joints[i].jerk, kWithin) << i;
    EXPECT_GE(joints[i].lowest, limits[i].lower) << i;
    EXPECT_LE(joints[i].highest, limits[i].upper) << i;
    EXPECT_GT(joints[i].acceleration, 0.9) << "joint " << i << " was hardly tried";
    overshoot = std::max(overshoot, watches[i].worst);
    steps += watches[i].steps;
  }
  EXPECT_LE(overshoot, kOvershoot);
  EXPECT_LE(wire.worst_units, 1) << "units between what left and what was decoded";
  EXPECT_LE(wire.outside, 1e-9) << "rad beyond a motor's range";
  EXPECT_GT(powered, kTicks * 9 / 10);
  EXPECT_GT(wire.frames, powered * 3 / 4) << "the others while a start fades";
  EXPECT_GT(stops, kTicks / 34'000);
  EXPECT_GT(holds, kTicks / 10'000);
  EXPECT_GT(steps, kTicks / 3'400) << "steps from rest";
  EXPECT_GT(hand.state().poses_refused, static_cast<std::uint64_t>(kTicks / 340));
  RecordProperty("overshoot_rad", fmt::format("{:.3g}", overshoot));
  RecordProperty("powered_ticks", std::to_string(powered));
  RecordProperty("frames", std::to_string(wire.frames));
  RecordProperty("worst_units", fmt::format("{:.4g}", wire.worst_units));
}

INSTANTIATE_TEST_SUITE_P(Examples,
                         EveryHandInAStorm,
                         ::testing::ValuesIn(config::texts::example_configs),
                         [](const auto& told) {
                           return told.param;
                         });

}  // namespace
}  // namespace handgraft::bridge
