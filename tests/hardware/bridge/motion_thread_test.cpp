// The motion's thread in real time, with a simulated hand: what is handed over arrives.

#include "hardware/bridge/motion_thread.h"

#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "hardware/config/hand_config_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::bridge {
namespace {

using safety::GovernorState;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class MotionThreadTest : public ::testing::Test {
 protected:
  MotionThreadTest()
      : config(config::readHandConfig(handgraft::test::sourceDirectory() / "hardware" /
                                      "config" / "examples" / "leap.yaml")) {
    config.device.kind = config::DeviceKind::kSimulated;
    // Patient: the machine may be busy.
    config.governor.stale_after = std::chrono::seconds(10);
    config.governor.longest_gap = std::chrono::seconds(10);
    config.governor.device_silent_after = std::chrono::seconds(10);
    config.governor.overruns_in_a_row = 100'000;
    const auto make = [this](const config::HandConfig& asked) {
      DeviceStack stack = makeDevice(asked, Clock::now);
      stack.device->stopWhen([this] {
        return estop_flag.load();
      });
      return stack;
    };
    thread = std::make_unique<MotionThread>(std::make_unique<Motion>(config, make, Clock::now),
                                            estop_flag, bell);
  }

  /// Keeps the stream alive until `wanted` holds; false after a minute.
  bool waitFor(const std::function<bool(const MotionState&)>& wanted) {
    const auto give_up = Clock::now() + std::chrono::minutes(1);
    while (Clock::now() < give_up) {
      thread->renew(1, Clock::now());
      if (const MotionState* news = thread->take(); news != nullptr && wanted(*news))
        return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }

  void offer(double share) {
    StreamPose pose;
    pose.stream = 1;
    pose.sequence = ++sequence;
    pose.arrived = Clock::now();
    pose.names = config.governor.names;
    for (const safety::JointLimits& limits : config.governor.limits)
      pose.joint_rad.push_back(limits.lower + share * (limits.upper - limits.lower));
    thread->offer(std::move(pose));
  }

  bool start() {
    offer(0.5);
    if (!waitFor([](const MotionState& state) {
          return state.state == GovernorState::kIdle && state.poses_accepted > 0;
        }))
      return false;
    thread->request(Request::kArm);
    return waitFor([](const MotionState& state) {
      return state.state == GovernorState::kArmed && state.is_powered;
    });
  }

  std::atomic<bool> estop_flag{false};
  const std::shared_ptr<WakeEvent> bell = std::make_shared<WakeEvent>();
  config::HandConfig config;
  std::uint64_t sequence = 0;
  std::unique_ptr<MotionThread> thread;
};

TEST_F(MotionThreadTest, RingsAfterEachPeriod) {
  for (int periods = 0; periods < 5;) {
    bell->wait(std::chrono::minutes(1));
    if (thread->take() == nullptr) continue;
    ++periods;
  }
}

TEST_F(MotionThreadTest, TheNewestPoseWins) {
  ASSERT_TRUE(start());
  const double wanted =
      config.governor.limits[0].lower +
      0.6 * (config.governor.limits[0].upper - config.governor.limits[0].lower);
  for (int k = 0; k <= 300; ++k)
    offer(0.3 + 0.001 * k);
  EXPECT_TRUE(waitFor([&](const MotionState& state) {
    return std::abs(state.position[0] - wanted) < 1e-3;
  }));
  EXPECT_EQ(thread->last().state, GovernorState::kArmed);
  EXPECT_LE(thread->last().poses_accepted, 302u);
}

// More than the ring has room for, within a period.
TEST_F(MotionThreadTest, AFloodOfRequestsLosesNoDisarming) {
  ASSERT_TRUE(start());
  for (int i = 0; i < 1000; ++i)
    thread->request(Request::kArm);
  thread->request(Request::kDisarm);
  EXPECT_TRUE(waitFor([](const MotionState& state) {
    return state.state == GovernorState::kIdle && !state.is_powered;
  }));
}

TEST_F(MotionThreadTest, AStopFromAnotherThreadIsLatchedAndItsFlagTaken) {
  ASSERT_TRUE(start());
  offer(0.9);
  std::thread other([this] {
    thread->estop();
  });
  other.join();
  EXPECT_TRUE(waitFor([](const MotionState& state) {
    return state.state == GovernorState::kEStop && !state.is_powered;
  }));
  EXPECT_FALSE(estop_flag);
  thread->request(Request::kArm);
  EXPECT_TRUE(waitFor([](const MotionState& state) {
    return !state.last_refusal.view().empty();
  }));
  EXPECT_EQ(thread->last().state, GovernorState::kEStop);
}

TEST_F(MotionThreadTest, AStopThatWasThereBeforeAnArmingWins) {
  offer(0.5);
  ASSERT_TRUE(waitFor([](const MotionState& state) {
    return state.state == GovernorState::kIdle && state.poses_accepted > 0;
  }));
  thread->request(Request::kArm);
  estop_flag = true;  // as a signal would
  EXPECT_TRUE(waitFor([](const MotionState& state) {
    return state.state == GovernorState::kEStop && !state.is_powered;
  }));
}

TEST_F(MotionThreadTest, EndsUnderPowerWithinItsBrakingTime) {
  ASSERT_TRUE(start());
  offer(0.9);
  thread.reset();  // joins, or this test never ends
}

}  // namespace
}  // namespace handgraft::bridge
