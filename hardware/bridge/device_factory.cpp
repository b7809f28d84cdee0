#include "hardware/bridge/device_factory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "hardware/bridge/simulated_device.h"
#include "hardware/config/wire_load.h"
#include "hardware/devices/ability_hand_device.h"
#include "hardware/devices/allegro_hand.h"
#include "hardware/devices/dynamixel_hand.h"
#include "hardware/devices/inspire_hand.h"
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

// Of the speeds that devices themselves keep: an ODrive axis switches itself off above its
// limit, and a loop that regulates goes a little beyond what it is asked for.
constexpr double kHeadroom = 1.5;

MotorScale scaleOf(const MotorConfig& motor, double rad_per_unit) {
  return {rad_per_unit / motor.gear, motor.zero_rad / rad_per_unit, motor.direction,
          motor.range_rad.lower, motor.range_rad.upper};
}

// What the bytes take on a tty is no delay of the device's.
devices::Duration patienceOf(const HandConfig& config) {
  return config.device.reply_timeout +
         std::chrono::duration_cast<devices::Duration>(
             std::chrono::duration<double>(config::cycleTime(config)));
}

std::unique_ptr<devices::Device> makeDynamixel(const HandConfig& config,
                                               devices::ByteChannel& bytes,
                                               const devices::Clock& clock) {
  devices::DynamixelConfig told;
  for (const MotorConfig& motor : config.motors) {
    devices::DynamixelMotor each;
    each.id = static_cast<std::uint8_t>(motor.id);
    each.scale = scaleOf(motor, protocols::dynamixel::kRadPerCount);
    const double limit_milliamp = std::clamp(std::round(1000 * motor.current_A), 0.0, 32000.0);
    each.current_limit_milliamp = static_cast<int>(limit_milliamp);
    each.velocity_limit_rad_s = kHeadroom * motor.velocity_rad_s * motor.gear;
    if (motor.gains) {
      each.gains = devices::DynamixelGains{static_cast<std::uint16_t>(motor.gains->p),
                                           static_cast<std::uint16_t>(motor.gains->i),
                                           static_cast<std::uint16_t>(motor.gains->d)};
    }
    told.motors.push_back(each);
  }
  told.watchdog = config.device.watchdog;
  told.reply_timeout = patienceOf(config);
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
    const auto place = static_cast<std::size_t>(config.motors[i].id);
    if (place >= told.order.size()) rejectInput("an Ability Hand has no motor {}", place);
    told.order[i] = place;
    told.lower[place] = config.motors[i].range_rad.lower;
    told.upper[place] = config.motors[i].range_rad.upper;
  }
  if (config.device.touch) told.reply = protocols::ability_hand::Reply::kTouchCurrent;
  told.reply_timeout = patienceOf(config);
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
    axis.velocity_limit_rev_s = kHeadroom * motor.velocity_rad_s * motor.gear / kTurn;
    axis.current_limit_A = motor.current_A;
    told.axes.push_back(axis);
  }
  told.firmware = config.device.firmware == config::ODriveFirmware::k05
                      ? protocols::odrive::Firmware::k05
                      : protocols::odrive::Firmware::k06;
  told.watchdog = config.device.watchdog;
  told.reply_timeout = config.device.reply_timeout;
  told.tolerated_misses = config.device.tolerated_misses;
  return std::make_unique<devices::ODriveHand>(std::move(told), can, clock);
}

constexpr double kInspireUnit = 1e-3;  // of a finger's way: a config counts that as 1 rad

std::unique_ptr<devices::Device> makeInspire(const HandConfig& config,
                                             devices::ByteChannel& bytes,
                                             const devices::Clock& clock) {
  devices::InspireConfig told;
  if (config.motors.size() != told.scales.size())
    rejectInput("an Inspire hand has {} motors, not {}", told.scales.size(),
                config.motors.size());
  for (std::size_t i = 0; i < told.scales.size(); ++i) {
    const auto place = static_cast<std::size_t>(config.motors[i].id);
    if (place >= told.order.size()) rejectInput("an Inspire hand has no motor {}", place);
    told.order[i] = place;
    told.scales[place] = scaleOf(config.motors[i], kInspireUnit);
  }
  told.address = static_cast<std::uint8_t>(config.device.address);
  told.force_N = config.device.force_N;
  told.reply_timeout = patienceOf(config);
  told.tolerated_misses = config.device.tolerated_misses;
  return std::make_unique<devices::InspireHand>(told, bytes, clock);
}

std::unique_ptr<devices::Device> makeAllegro(const HandConfig& config,
                                             devices::CanChannel& can,
                                             const devices::Clock& clock) {
  devices::AllegroConfig told;
  if (config.motors.size() != told.scales.size())
    rejectInput("an Allegro Hand has {} motors, not {}", told.scales.size(),
                config.motors.size());
  for (std::size_t i = 0; i < told.scales.size(); ++i) {
    const auto place = static_cast<std::size_t>(config.motors[i].id);
    if (place >= told.order.size()) rejectInput("an Allegro Hand has no motor {}", place);
    told.order[i] = place;
    told.scales[place] = scaleOf(config.motors[i], protocols::allegro::kRadPerCount);
  }
  told.stiffness = config.device.stiffness;
  told.damping = config.device.damping;
  told.torque = config.device.torque;
  told.reply_timeout = config.device.reply_timeout;
  told.tolerated_misses = config.device.tolerated_misses;
  return std::make_unique<devices::AllegroHand>(told, can, clock);
}

/// How the device of a kind is made, on the wire that the kind hangs on.
struct Maker {
  DeviceKind kind;
  std::unique_ptr<devices::Device> (*on_bytes)(const HandConfig&,
                                               devices::ByteChannel&,
                                               const devices::Clock&);
  std::unique_ptr<devices::Device> (*on_can)(const HandConfig&,
                                             devices::CanChannel&,
                                             const devices::Clock&);
};

constexpr std::array<Maker, 5> kMakers = {{
    {DeviceKind::kDynamixel, makeDynamixel, nullptr},
    {DeviceKind::kAbilityHand, makeAbilityHand, nullptr},
    {DeviceKind::kODrive, nullptr, makeODrive},
    {DeviceKind::kInspire, makeInspire, nullptr},
    {DeviceKind::kAllegro, nullptr, makeAllegro},
}};

const Maker& makerOf(const HandConfig& config) {
  const auto found = std::find_if(kMakers.begin(), kMakers.end(), [&](const Maker& maker) {
    return maker.kind == config.device.kind;
  });
  if (found == kMakers.end()) rejectInput("a simulated hand has no wire");
  return *found;
}

bool isOnCan(DeviceKind kind) {
  return config::traitsOf(kind).wire == config::DeviceWire::kCan;
}

std::vector<int> nodesOf(const HandConfig& config) {
  std::vector<int> nodes;
  // Ids of a hand that comes as a whole are no axes': all of them are let through.
  if (config::traitsOf(config.device.kind).own_motors > 0) {
    nodes.resize(protocols::odrive::kHighestNode + 1);
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  }
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
  const Maker& maker = makerOf(config);
  DeviceStack stack;
  if (isOnCan(config.device.kind)) {
    stack.can =
        std::make_unique<devices::SlcanChannel>(bytes, config.device.can_bitrate, clock);
    stack.device = maker.on_can(config, *stack.can, clock);
  } else {
    stack.device = maker.on_bytes(config, bytes, clock);
  }
  return stack;
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
  if (isOnCan(config.device.kind) && config.device.carrier == config::CanCarrier::kSocketCan) {
    stack.can = std::make_unique<devices::SocketCanChannel>(
        devices::canInterface(config.device.port, nodesOf(config)));
    stack.device = makerOf(config).on_can(config, *stack.can, clock);
    return stack;
  }
  auto port = std::make_unique<devices::SerialPort>(config.device.port, config.device.baud);
  stack = makeDeviceOn(*port, config, clock);
  stack.bytes = std::move(port);
  return stack;
}

std::string nameOf(const config::DeviceConfig& device) {
  const config::DeviceTraits& traits = config::traitsOf(device.kind);
  return traits.wire == config::DeviceWire::kNone ? traits.name
                                                  : traits.name + (" " + device.port);
}

}  // namespace handgraft::bridge
