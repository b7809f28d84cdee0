// No period of a hand under power allocates. In the program that counts operator new.

#include <gtest/gtest.h>

#include "hardware/bridge/motion.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/allocation_count.h"
#include "tests/support/shared_data.h"

namespace handgraft::bridge {
namespace {

using handgraft::test::allocationCount;
using std::chrono::milliseconds;

// The devices' own turns are counted on ptys, in EveryDeviceOnAPty.
TEST(MotionAllocation, NoPeriodUnderPowerAllocates) {
  config::HandConfig config =
      config::readHandConfig(handgraft::test::sourceDirectory() / "hardware" / "config" /
                             "examples" / "printed_tendon_hand.yaml");
  config.device.kind = config::DeviceKind::kSimulated;
  config.homing.clear();
  safety::Time now{std::chrono::hours(1)};
  const devices::Clock clock = [&now] {
    return now;
  };
  Motion motion(
      config,
      [&](const config::HandConfig& asked) {
        return makeDevice(asked, clock);
      },
      clock);
  MotionState copy = motion.state();
  StreamPose pose;
  pose.stream = 1;
  pose.names = config.governor.names;
  pose.joint_rad.assign(pose.names.size(), 0.5);
  motion.turn();
  const auto offer = [&] {
    ++pose.sequence;
    pose.arrived = now;
    motion.offer(pose);
  };
  offer();
  motion.request(Request::kArm);
  for (int k = 0; k < 5; ++k) {
    now += milliseconds(10);
    motion.turn();
  }
  ASSERT_TRUE(motion.state().is_powered);
  TimedPose sample;
  sample.stream = pose.stream;
  sample.joint_rad = pose.joint_rad;
  const long before = allocationCount();
  for (int k = 0; k < 300; ++k) {
    now += milliseconds(10);
    pose.joint_rad.assign(pose.names.size(), k % 50 < 25 ? 0.1 : 0.8);
    offer();
    motion.turn();
    copy = motion.state();
  }
  for (int k = 0; k < 300; ++k) {
    now += milliseconds(10);
    sample.source_ns = 10'000'000 * (k - k % 3);  // two of three are repeats
    sample.arrived = now;
    motion.offer(sample);
    motion.turn();
    copy = motion.state();
  }
  EXPECT_TRUE(motion.state().is_guided);
  EXPECT_EQ(motion.state().state, safety::GovernorState::kArmed);
  motion.estop();
  for (int k = 0; k < 100; ++k) {
    now += milliseconds(10);
    motion.turn();
  }
  EXPECT_EQ(allocationCount(), before);
  EXPECT_FALSE(motion.state().is_powered);
}

}  // namespace
}  // namespace handgraft::bridge
