#include "hardware/bridge/device_factory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "hardware/bridge/simulated_device.h"
#include "hardware/devices/ability_hand_device.h"
#include "hardware/devices/dynamixel_hand.h"
#include "hardware/devices/odrive_hand.h"
#include "hardware/devices/serial_port.h"
#include "hardware/devices/slcan_channel.h"
#include "hardware/devices/socket_can_channel.h"

namespace handgraft::bridge {

namespace {

using config::DeviceKind;
using config::HandConfig;
using config::MotorConfig;
using devices::MotorScale;

// An ODrive axis switches itself off above its velocity limit; a loop that regulates goes a
// little beyond what it is asked for.
constexpr double kODriveHeadroom = 1.5;

MotorScale scaleOf(const MotorConfig& motor, double rad_per_unit) {
  return {rad_per_unit / motor.gear, motor.zero_rad / rad_per_unit, motor.direction,
          motor.range_rad.lower, motor.range_rad.upper};
}

std::unique_ptr<devices::Device> makeDynamixel(const HandConfig& config,
                                               devices::ByteChannel& bytes,
                                               const devices::Clock& clock) {
  devices::DynamixelConfig told;
  for (const MotorConfig& motor : config.motors) {
    devices::DynamixelMotor each;
    each.id = static_cast<std::uint8_t>(motor.id);
    each.scale = scaleOf(motor, protocols::dynamixel::kRadPerCount);
    const double limit_mA = std::clamp(std::round(1000 * motor.current_A), 0.0, 32000.0);
    each.current_limit_mA = static_cast<std::int16_t>(limit_mA);
    told.motors.push_back(each);
  }
  told.watchdog = config.device.watchdog;
  told.reply_timeout = config.device.reply_timeout;
  told.tolerated_misses = config.device.tolerated_misses;
  return std::make_unique<devices::DynamixelHand>(std::move(told), bytes, clock);
}

std::unique_ptr<devices::Device> makeAbilityHand(const HandConfig& config,
                                                 devices::ByteChannel& bytes,
                                                 const devices::Clock& clock) {
  devices::AbilityHandConfig told;
  if (config.motors.size() != told.lower.size())
    rejectInput("an Ability Hand has {} motors, not {}", told.lower.size(),
                config.motors.size());
  told.address = static_cast<std::uint8_t>(config.device.address);
  for (std::size_t i = 0; i < told.lower.size(); ++i) {
    told.lower[i] = config.motors[i].range_rad.lower;
    told.upper[i] = config.motors[i].range_rad.upper;
  }
  told.reply_timeout = config.device.reply_timeout;
  told.tolerated_misses = config.device.tolerated_misses;
  told.longest_gap = config.governor.longest_gap;
  // The governor holds first, which may be all that is needed.
  told.hot_patience = 2 * config.governor.limited_for;
  return std::make_unique<devices::AbilityHandDevice>(told, bytes, clock);
}

std::unique_ptr<devices::Device> makeODrive(const HandConfig& config,
                                            devices::CanChannel& can,
                                            const devices::Clock& clock) {
  constexpr double kTurn = 2 * std::numbers::pi;
  devices::ODriveConfig told;
  for (const MotorConfig& motor : config.motors) {
    devices::ODriveAxis axis;
    axis.node = motor.id;
    axis.scale = scaleOf(motor, kTurn);
    axis.velocity_limit_rev_s = kODriveHeadroom * motor.velocity_rad_s * motor.gear / kTurn;
    axis.current_limit_A = motor.current_A;
    told.axes.push_back(axis);
  }
  told.firmware = config.device.firmware == config::ODriveFirmware::k05
                      ? protocols::odrive::Firmware::k05
                      : protocols::odrive::Firmware::k06;
  told.reply_timeout = config.device.reply_timeout;
  told.tolerated_misses = config.device.tolerated_misses;
  return std::make_unique<devices::ODriveHand>(std::move(told), can, clock);
}

std::vector<int> nodesOf(const HandConfig& config) {
  std::vector<int> nodes;
  for (const MotorConfig& motor : config.motors)
    nodes.push_back(motor.id);
  return nodes;
}

std::unique_ptr<devices::Device> makeSimulated(const HandConfig& config,
                                               const devices::Clock& clock,
                                               std::span<const double> start) {
  std::vector<SimulatedMotor> motors;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const MotorConfig& motor = config.motors[i];
    motors.push_back({motor.range_rad.lower, motor.range_rad.upper, motor.velocity_rad_s,
                      start.empty() ? 0.0 : start[i]});
  }
  return std::make_unique<SimulatedDevice>(motors, clock);
}

}  // namespace

DeviceStack makeDeviceOn(devices::ByteChannel& bytes,
                         const HandConfig& config,
                         const devices::Clock& clock) {
  DeviceStack stack;
  switch (config.device.kind) {
    case DeviceKind::kDynamixel:
      stack.device = makeDynamixel(config, bytes, clock);
      return stack;
    case DeviceKind::kAbilityHand:
      stack.device = makeAbilityHand(config, bytes, clock);
      return stack;
    case DeviceKind::kODrive:
      stack.can =
          std::make_unique<devices::SlcanChannel>(bytes, config.device.can_bitrate, clock);
      stack.device = makeODrive(config, *stack.can, clock);
      return stack;
    case DeviceKind::kSimulated:
      break;
  }
  rejectInput("a simulated hand has no wire");
}

DeviceStack makeDevice(const HandConfig& config,
                       const devices::Clock& clock,
                       std::span<const double> simulated_start) {
  DeviceStack stack;
  if (config.device.kind == DeviceKind::kSimulated) {
    HANDGRAFT_REQUIRE(simulated_start.empty() ||
                      simulated_start.size() == config.motors.size());
    stack.device = makeSimulated(config, clock, simulated_start);
    return stack;
  }
  if (config.device.kind == DeviceKind::kODrive &&
      config.device.carrier == config::CanCarrier::kSocketCan) {
    stack.can = std::make_unique<devices::SocketCanChannel>(
        devices::canInterface(config.device.port, nodesOf(config)));
    stack.device = makeODrive(config, *stack.can, clock);
    return stack;
  }
  auto port = std::make_unique<devices::SerialPort>(config.device.port, config.device.baud);
  stack = makeDeviceOn(*port, config, clock);
  stack.bytes = std::move(port);
  return stack;
}

std::string nameOf(const config::DeviceConfig& device) {
  switch (device.kind) {
    case DeviceKind::kSimulated:
      return "simulated";
    case DeviceKind::kDynamixel:
      return "dynamixel " + device.port;
    case DeviceKind::kAbilityHand:
      return "ability_hand " + device.port;
    case DeviceKind::kODrive:
      return "odrive " + device.port;
  }
  return "unknown";
}

}  // namespace handgraft::bridge
