#include "hardware/bridge/duplicate_bridge_monitor.h"

#include <gtest/gtest.h>

namespace handgraft::bridge {
namespace {

using namespace std::chrono_literals;

constexpr DuplicateBridgeMonitor::Time kStart{1h};

v1::BridgeStatus statusOf(std::uint32_t bridge, std::int64_t stamp_ns) {
  v1::BridgeStatus status;
  status.bridge_id(bridge);
  status.device("dynamixel /dev/ttyUSB0");
  status.hand("leap");
  status.stamp_ns(stamp_ns);
  return status;
}

TEST(DuplicateBridgeMonitor, NamesAnotherBridgeOfTheSameNumber) {
  DuplicateBridgeMonitor watch(3);
  EXPECT_FALSE(watch.rival(kStart));
  watch.see(statusOf(3, 10), kStart);
  watch.see(statusOf(3, 11), kStart + 100ms);
  EXPECT_EQ(watch.rival(kStart + 100ms), "dynamixel /dev/ttyUSB0, hand 'leap'");
}

TEST(DuplicateBridgeMonitor, IsNotItself) {
  DuplicateBridgeMonitor watch(3);
  for (int i = 1; i <= 200; ++i) {
    watch.noteOwn(i);
    watch.noteOwn(1000 + i);
    watch.see(statusOf(3, i), kStart + i * 100ms);
    EXPECT_FALSE(watch.rival(kStart + i * 100ms));
  }
}

TEST(DuplicateBridgeMonitor, IsFoundAmongOnesOwnStatuses) {
  DuplicateBridgeMonitor watch(3);
  for (int i = 1; i <= 3; ++i) {
    watch.noteOwn(i);
    watch.see(statusOf(3, i), kStart + i * 100ms);
    watch.see(statusOf(3, 1000 + i), kStart + i * 100ms);
  }
  EXPECT_TRUE(watch.rival(kStart + 300ms));
}

TEST(DuplicateBridgeMonitor, BridgesOfOtherNumbersAreNone) {
  DuplicateBridgeMonitor watch(3);
  for (int i = 1; i <= 3; ++i)
    watch.see(statusOf(4, i), kStart);
  EXPECT_FALSE(watch.rival(kStart));
}

TEST(DuplicateBridgeMonitor, TheLastWordOfOneThatEndedIsNone) {
  DuplicateBridgeMonitor watch(3);
  watch.see(statusOf(3, 10), kStart);
  watch.see(statusOf(3, 10), kStart + 10ms);
  EXPECT_FALSE(watch.rival(kStart + 10ms)) << "the same status twice";
  watch.see(statusOf(3, 11), kStart + 20ms);
  EXPECT_TRUE(watch.rival(kStart + 2s));
  EXPECT_FALSE(watch.rival(kStart + 3s)) << "it is gone";
  watch.see(statusOf(3, 12), kStart + 10s);
  EXPECT_FALSE(watch.rival(kStart + 10s)) << "the count begins anew";
}

}  // namespace
}  // namespace handgraft::bridge
