#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// The control table of the X series with current control, as data.
namespace handgraft::protocols::dynamixel {

/// One register. EEPROM registers can be written only while the torque is off.
struct Register {
  std::uint16_t address;
  std::uint8_t size;  ///< bytes: 1, 2 or 4; low byte first, two's complement
  bool is_signed;
  bool is_eeprom;
  bool is_writable;
  std::int32_t start;  ///< value from the factory, or after power-up
  std::string_view name;
};

/// Sorted by address. Source: e-Manual, control table of the XC330-M288-T. The other models
/// have the same registers at the same addresses, named as Dynamixel Wizard names them, but for
/// what `ModelFacts` tells; their start values may differ.
std::span<const Register> controlTable();

/// The register of that name. Errors: BrokenContract if there is none.
const Register& registerNamed(std::string_view name);

/// What differs between the models.
struct ModelFacts {
  std::string_view name;
  std::uint16_t number;  ///< register 0, and in a ping's reply
  /// Of registers 38, 102 and 126; 0: the motor measures no current and cannot limit it.
  double current_unit_milliamp;
  std::int16_t
      highest_current;  ///< of register 38, in that unit; 0: the motor itself refuses more
  std::uint8_t shutdown_errors;  ///< register 63: hardware errors that cut the torque
  std::uint16_t indirect_data;   ///< where the bytes of the indirect addresses are read
};

/// All of them, also those that a hand cannot be driven with.
std::span<const ModelFacts> models();

/// Nothing for a number that is not in the table.
std::optional<ModelFacts> modelNumbered(std::uint16_t number);

// === Units

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr int kCountsPerRevolution = 4096;
inline constexpr double kRadPerCount = 2.0 * kPi / kCountsPerRevolution;
inline constexpr double kVelocityUnit = 0.229 * 2.0 * kPi / 60.0;  ///< rad/s
inline constexpr int kWatchdogUnitMs = 20;
inline constexpr int kLongestWatchdog = 127;  ///< in `kWatchdogUnit_ms`
/// Goal positions of the modes over several turns, either way.
inline constexpr std::int32_t kFarthestGoal = 1048575;

// === Values

inline constexpr std::uint8_t kCurrentBasedPositionMode = 5;
inline constexpr std::uint8_t kWatchdogTripped = 0xFF;  ///< register 98 after it has fired

/// Bits of register 70. Any of them that is in register 63 cuts the torque until a reboot.
enum HardwareError : std::uint8_t {
  kInputVoltage = 0x01,
  kOverheating = 0x04,
  kEncoder = 0x08,
  kElectricalShock = 0x10,
  kOverload = 0x20,
};

// === Indirect addresses: which 20 single bytes can be read in one piece

inline constexpr std::uint16_t kIndirectAddresses = 168;  ///< 20 x 2 bytes
/// Of the XL330 and XC330, 20 bytes. Differs: text that their e-Manual shares with the others
/// says 224, which is theirs alone.
inline constexpr std::uint16_t kIndirectData = 208;
inline constexpr std::uint16_t kIndirectDataOfOthers = 224;
inline constexpr int kIndirectCount = 20;

}  // namespace handgraft::protocols::dynamixel
