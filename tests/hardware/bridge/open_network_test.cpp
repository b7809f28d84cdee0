#include "hardware/bridge/open_network.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::bridge {
namespace {

const NetworkInterface loopback{"lo", "127.0.0.1", true};
const NetworkInterface ethernet{"eth0", "192.168.1.2", false};

config::HandConfig handOf(config::DeviceKind kind) {
  config::HandConfig hand;
  hand.hand = "leap";
  hand.device.kind = kind;
  return hand;
}

TEST(OpenNetwork, MotorsAreNotDrivenWhereAnybodyMayArmThem) {
  for (const auto kind : {config::DeviceKind::kDynamixel, config::DeviceKind::kAbilityHand,
                          config::DeviceKind::kODrive, config::DeviceKind::kInspire,
                          config::DeviceKind::kAllegro}) {
    EXPECT_THROW(requireClosedNetwork(ethernet, handOf(kind), false), InvalidInput);
    EXPECT_NO_THROW(requireClosedNetwork(ethernet, handOf(kind), true)) << "it was said";
    EXPECT_NO_THROW(requireClosedNetwork(loopback, handOf(kind), false));
  }
}

TEST(OpenNetwork, SimulatedHandsHurtNobody) {
  EXPECT_NO_THROW(requireClosedNetwork(ethernet, std::nullopt, false));
  EXPECT_NO_THROW(
      requireClosedNetwork(ethernet, handOf(config::DeviceKind::kSimulated), false));
}

}  // namespace
}  // namespace handgraft::bridge
