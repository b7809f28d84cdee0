#include "hardware/config/device_kinds.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace handgraft::config {

namespace {

constexpr auto kNone = DeviceWire::kNone, kTty = DeviceWire::kTty, kCan = DeviceWire::kCan;

// kind, name, wire, baud, CAN bit rate, own motors, highest id; watchdog, zeros, own loop
constexpr std::array<DeviceTraits, 6> kKinds = {{
    {DeviceKind::kSimulated, "simulated", kNone, 0, 0, 0, 1'000'000, true, false, true},
    {DeviceKind::kDynamixel, "dynamixel", kTty, 4'000'000, 0, 0, 252, true, false, true},
    {DeviceKind::kAbilityHand, "ability_hand", kTty, 460'800, 0, 6, 5, true, true, true},
    {DeviceKind::kODrive, "odrive", kCan, 115'200, 500'000, 0, 63, true, false, true},
    {DeviceKind::kInspire, "inspire", kTty, 115'200, 0, 6, 5, false, true, true},
    {DeviceKind::kAllegro, "allegro", kCan, 115'200, 1'000'000, 16, 15, false, false, false},
}};

}  // namespace

std::span<const DeviceTraits> deviceKinds() {
  return kKinds;
}

const DeviceTraits& traitsOf(DeviceKind kind) {
  const auto found = std::find_if(kKinds.begin(), kKinds.end(), [kind](const auto& traits) {
    return traits.kind == kind;
  });
  HANDGRAFT_REQUIRE(found != kKinds.end());
  return *found;
}

}  // namespace handgraft::config
