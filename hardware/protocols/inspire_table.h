#pragma once

#include <array>
#include <cstdint>

/// Registers of an Inspire RH56 hand, six fingers each: little, ring, middle, index, thumb
/// bending, thumb turning. An address counts bytes, two to a register. Source: Inspire-Robots,
/// RH56 user manual, register table; as its public SDKs use it.
namespace handgraft::protocols::inspire {

inline constexpr std::size_t kMotorCount = 6;

inline constexpr std::uint16_t kClearError = 1004;  ///< 1: clears what can be cleared
inline constexpr std::uint16_t kAngleSet = 1486;    ///< 0 closed to 1000 open
inline constexpr std::uint16_t kForceSet = 1498;    ///< g, 0 to 1000: where a finger stops
inline constexpr std::uint16_t kSpeedSet = 1522;    ///< 0 to 1000
inline constexpr std::uint16_t kAngleAct = 1546;
inline constexpr std::uint16_t kForceAct = 1582;     ///< g, signed
inline constexpr std::uint16_t kCurrentAct = 1594;   ///< mA
inline constexpr std::uint16_t kError = 1606;        ///< a byte each, two to a register
inline constexpr std::uint16_t kTemperature = 1618;  ///< degrees Celsius, a byte each

inline constexpr std::uint16_t kFullAngle = 1000;
inline constexpr std::uint16_t kFullSpeed = 1000;
inline constexpr std::uint16_t kFullForce = 1000;
inline constexpr double kNewtonPerGram = 9.80665e-3;

/// Bits of an error byte.
enum Error : std::uint8_t {
  kStalled = 0x01,
  kOverheated = 0x02,
  kOverCurrent = 0x04,
  kMotor = 0x08,
  kCommunication = 0x10,
};

}  // namespace handgraft::protocols::inspire
