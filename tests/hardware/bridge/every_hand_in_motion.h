#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hardware/bridge/telemetry.h"

#include "tests/hardware/bridge/hand_in_motion.h"

namespace handgraft::bridge::test {

inline double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// An example that needs no homing any more.
inline config::HandConfig exampleReady(const std::string& name) {
  config::HandConfig config = exampleConfig(name);
  config.homing.clear();  // as if it had been homed
  return config;
}

/// The example configs in motion, on emulated devices and in virtual time.
class EveryHandInMotion : public ::testing::TestWithParam<std::string> {
 protected:
  EveryHandInMotion() : hand(exampleReady(GetParam())) {}

  [[nodiscard]] safety::GovernorState state() const { return hand.state().state; }

  [[nodiscard]] std::string told() const { return describe(hand.state()); }

  [[nodiscard]] const config::DeviceTraits& traits() {
    return config::traitsOf(hand.motion().config().device.kind);
  }

  void expectOffForGood() {
    hand.rig().wire().pass(std::chrono::milliseconds(500));
    EXPECT_FALSE(hand.rig().isPowered());
    const std::vector<double> before = hand.angles();
    hand.offer(0.9);
    hand.motion().request(Request::kArm);
    hand.turnFor(0.5);
    EXPECT_LT(largestDifference(before, hand.angles()), 1e-9) << "it moved: " << told();
  }

  HandInMotion hand;
};

}  // namespace handgraft::bridge::test
