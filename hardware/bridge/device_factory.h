#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "hardware/config/hand_config.h"
#include "hardware/devices/byte_channel.h"
#include "hardware/devices/can_channel.h"
#include "hardware/devices/device.h"

namespace handgraft::bridge {

/// A device and the wire it speaks over; the wire outlives it.
struct DeviceStack {
  std::unique_ptr<devices::ByteChannel> bytes;
  std::unique_ptr<devices::CanChannel> can;
  std::unique_ptr<devices::Device> device;
};

/// Makes the device that a config tells; tests put an emulated one in its place.
using MakeDevice = std::function<DeviceStack(const config::HandConfig&)>;

/// The device of `config` on its own wire, not yet open. A simulated one starts at
/// `simulated_start` (rad, one per motor), or where that is empty at 0, inside each range.
/// Errors: InvalidInput for what its driver does not accept.
DeviceStack makeDevice(const config::HandConfig& config,
                       const devices::Clock& clock,
                       std::span<const double> simulated_start = {});

/// The same on a wire that is there already; for what speaks bytes.
DeviceStack makeDeviceOn(devices::ByteChannel& bytes,
                         const config::HandConfig& config,
                         const devices::Clock& clock);

/// For people: "dynamixel /dev/ttyUSB0", "simulated".
std::string nameOf(const config::DeviceConfig& device);

}  // namespace handgraft::bridge
