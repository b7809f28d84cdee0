#include "hardware/config/wire_load.h"

#include <algorithm>

namespace handgraft::config {

namespace {

constexpr double kBitsPerByte = 10;  // 8N1

// A sync read of all, the answers of 14 bytes each, a sync write of 4 bytes each.
double dynamixelBytes(double motors) {
  constexpr double kFrame = 10;  // header, id, length, instruction, CRC
  constexpr double kBlock = 14;
  const double question = kFrame + 4 + motors;
  const double answers = motors * (kFrame + 1 + kBlock);
  const double targets = kFrame + 4 + motors * (1 + 4);
  return question + answers + targets;
}

// A command of 15 bytes and a reply between two flags each; two bytes in 256 are stuffed.
double abilityHandBytes(bool touch) {
  constexpr double kCommand = 15 + 2;
  const double reply = (touch ? 72 : 39) + 2;
  return (kCommand + reply) * 258 / 256;
}

// Angles read and written, and one more of six registers read; a pause of 3.5 bytes between any
// two.
double inspireBytes() {
  constexpr double kRead = 8 + (5 + 12), kWrite = (9 + 12) + 8;
  return 2 * kRead + kWrite + 6 * 3.5;
}

double canBits(double bytes) {
  return (47 + 8 * bytes) * 1.2;
}

// Per axis a question, its answer and a target, and the estimates that come by themselves every
// 10 ms; in a cycle a current and the temperatures, asked for and told.
struct ODriveFrames {
  double empty, full;
};

ODriveFrames odriveFrames(double axes, double period_s) {
  return {axes + 2, 2 * axes + 2 + axes * period_s / 0.010};
}

}  // namespace

double cycleTime(const HandConfig& config) {
  const DeviceConfig& device = config.device;
  const auto motors = static_cast<double>(config.motors.size());
  const auto on_tty = [&](double bytes) {
    return kBitsPerByte * bytes / std::max(device.baud, 1);
  };
  switch (device.kind) {
    case DeviceKind::kSimulated:
      return 0;
    case DeviceKind::kDynamixel:
      return on_tty(dynamixelBytes(motors));
    case DeviceKind::kAbilityHand:
      return on_tty(abilityHandBytes(device.touch));
    case DeviceKind::kInspire:
      return on_tty(inspireBytes());
    case DeviceKind::kAllegro: {
      // Of each finger a question, its answer and torques; of one its temperatures.
      const double bits = 5 * canBits(0) + 8 * canBits(8) + canBits(4);
      const double text = 5 * (5 + 2) + 8 * (6 + 16) + 4 * 2 + (6 + 8);
      const bool is_uart = device.carrier == CanCarrier::kSlcan && device.is_baud_told;
      return std::max(bits / std::max(device.can_bitrate, 1), is_uart ? on_tty(text) : 0);
    }
    case DeviceKind::kODrive: {
      const ODriveFrames frames = odriveFrames(motors, config.governor.period_s);
      const double bits = frames.empty * canBits(0) + frames.full * canBits(8);
      const double can = bits / std::max(device.can_bitrate, 1);
      // As text, 6 characters and 2 a byte; of those that are sent, 2 come back.
      const double text = frames.empty * (6 + 2) + frames.full * (6 + 16) + motors * 2;
      const bool is_uart = device.carrier == CanCarrier::kSlcan && device.is_baud_told;
      return is_uart ? std::max(can, on_tty(text)) : can;
    }
  }
  return 0;
}

}  // namespace handgraft::config
