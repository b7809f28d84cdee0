#include "hardware/config/device_section.h"

#include <utility>
#include <vector>

#include "core/base/error.h"

namespace handgraft::config {

DeviceConfig readDevice(Section section) {
  DeviceConfig device;
  std::vector<std::pair<const char*, DeviceKind>> kinds;
  for (const DeviceTraits& traits : deviceKinds())
    kinds.emplace_back(traits.name, traits.kind);
  device.kind = section.choice<DeviceKind>("kind", kinds);
  if (section.isWrong("kind")) {  // which keys there are depends on it
    section.allow({"port", "reply_timeout_ms", "tolerated_misses", "carrier", "firmware",
                   "can_bitrate", "baud", "address", "touch", "watchdog_ms", "no_watchdog",
                   "force_N", "stiffness_Nm_rad", "damping_Nm_s_rad", "torque_Nm"});
    section.finish();
    return device;
  }
  const DeviceTraits& traits = traitsOf(device.kind);
  const bool is_can = traits.wire == DeviceWire::kCan;
  const bool is_ability_hand = device.kind == DeviceKind::kAbilityHand;
  if (traits.wire != DeviceWire::kNone) {
    device.port = section.text("port");
    device.reply_timeout = section.duration("reply_timeout_ms", 1, 100, device.reply_timeout);
    device.tolerated_misses = section.integer("tolerated_misses", 0, 50, 3);
  }
  if (is_can) {
    device.carrier = section.choice<CanCarrier>(
        "carrier", {{"slcan", CanCarrier::kSlcan}, {"socketcan", CanCarrier::kSocketCan}});
    device.can_bitrate = section.integer("can_bitrate", 10'000, 1'000'000, traits.can_bitrate);
  }
  if (device.kind == DeviceKind::kODrive) {
    device.firmware = section.choice<ODriveFirmware>(
        "firmware", {{"0.5", ODriveFirmware::k05}, {"0.6", ODriveFirmware::k06}},
        ODriveFirmware::k06);
  }
  const bool is_network = is_can && device.carrier == CanCarrier::kSocketCan;
  if (traits.wire != DeviceWire::kNone && !is_network) {
    device.is_baud_told = section.has("baud");
    device.baud = section.integer("baud", 1200, 4'500'000, traits.baud);
  }
  if (is_ability_hand) device.address = section.integer("address", 1, 255, 0x50);
  if (is_ability_hand) device.touch = section.flag("touch", false);
  if (device.kind == DeviceKind::kInspire) {
    device.address = section.integer("address", 1, 254, 1);
    device.force_N = section.number("force_N", 0.1, 9.8, device.force_N);
  }
  if (device.kind == DeviceKind::kAllegro) {
    device.stiffness = section.number("stiffness_Nm_rad", 0.01, 10, device.stiffness);
    device.damping = section.number("damping_Nm_s_rad", 0, 1, device.damping);
    device.torque = section.number("torque_Nm", 0.001, 1, device.torque);
  }
  if (traits.has_watchdog) {
    device.watchdog =
        section.duration("watchdog_ms", 20, 2540,
                         is_ability_hand ? std::chrono::milliseconds(300) : device.watchdog);
  } else if (section.text("no_watchdog", "") != "accepted" && !section.isWrong("no_watchdog")) {
    // Nobody is to find that out when it matters.
    section.object(
        "no_watchdog",
        fmt::format("a device of kind {} has no watchdog: should the bridge die, its "
                    "motors go on turning as they were told last, until somebody cuts "
                    "their power. Write `no_watchdog: accepted` if you accept that",
                    traits.name));
  }
  section.finish();
  return device;
}

void usePort(DeviceConfig& device, const std::string& port) {
  const DeviceTraits& traits = traitsOf(device.kind);
  if (port.empty()) rejectInput("--port '': it names no port");
  if (traits.wire == DeviceWire::kNone)
    rejectInput("--port {}: a simulated hand has none", handgraft::quoted(port));
  device.port = port;
  if (traits.wire != DeviceWire::kCan) return;
  device.carrier = port.front() == '/' ? CanCarrier::kSlcan : CanCarrier::kSocketCan;
  if (device.baud == 0) device.baud = traits.baud;
}

}  // namespace handgraft::config
