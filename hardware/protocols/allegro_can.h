#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hardware/protocols/can_frame.h"

/// Messages of an Allegro Hand (version 4 and its successors' compatible mode): an 11-bit id
/// that holds a command in its upper nine bits, four numbers of 16 bits, low byte first, of one
/// finger. Fingers: index, middle, little, thumb; of each four joints from the palm on. Source:
/// SimLab, allegro_hand_ros_v4, candef.h and the driver's conversions.
namespace handgraft::protocols::allegro {

inline constexpr std::size_t kFingerCount = 4;
inline constexpr std::size_t kJointsOfFinger = 4;
inline constexpr std::size_t kMotorCount = kFingerCount * kJointsOfFinger;

enum class Command : std::uint16_t {
  kFingerPose = 0x20,   ///< +finger: asked for by a remote frame, told by the hand
  kTemperature = 0x38,  ///< +finger: the same; degrees Celsius, a byte a joint
  kSystemOn = 0x40,
  kSystemOff = 0x41,
  kSetTorque = 0x60,  ///< +finger
  kSetPeriod = 0x81,
  kHandInfo = 0x80,
};

/// rad of a count: 333.3 degrees over 16 bits.
inline constexpr double kRadPerCount = 333.3 / 65536.0 * 3.14159265358979323846 / 180.0;
inline constexpr double kPwmPerNm = 1200.0;
inline constexpr int kHighestPwm = 1200;

using Numbers = std::array<std::int16_t, kJointsOfFinger>;

/// `finger` 0 to 3 for what is one finger's, else 0.
std::uint32_t idOf(Command command, std::size_t finger = 0);

CanFrame systemOn();
CanFrame systemOff();
CanFrame askFor(Command command, std::size_t finger);
CanFrame setTorque(std::size_t finger, const Numbers& pwm);

struct FingerNumbers {
  std::size_t finger = 0;
  Numbers numbers{};
};

/// None for a frame of another command, a remote frame, or too few bytes.
std::optional<FingerNumbers> poseOf(const CanFrame& frame);
std::optional<FingerNumbers> temperatureOf(const CanFrame& frame);
std::optional<FingerNumbers> torqueOf(const CanFrame& frame);

// === What the hand sends, for emulators

CanFrame makePose(std::size_t finger, const Numbers& counts);
CanFrame makeTemperature(std::size_t finger, const std::array<std::uint8_t, 4>& celsius);

}  // namespace handgraft::protocols::allegro
