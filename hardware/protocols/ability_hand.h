#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "hardware/protocols/bytes.h"
#include "hardware/protocols/stream_reader.h"

/// Frames of the PSYONIC Ability Hand's extended API over a UART, with byte stuffing.
///
/// On the wire: 7E, content, checksum, 7E; 7D escapes 7E and 7D inside. Numbers low byte first.
/// Six motors: index, middle, ring, pinky, thumb flexor, thumb rotator.
/// Source: PSYONIC, "Ability Hand ICD", section 3, where nothing else is said.
namespace handgraft::protocols::ability_hand {

inline constexpr int kMotorCount = 6;
inline constexpr int kThumbRotator = 5;
inline constexpr int kTouchCount = 30;  ///< six places each of index, ..., pinky, thumb
inline constexpr std::uint8_t kDefaultAddress = 0x50;

using Counts = std::array<std::int16_t, kMotorCount>;

/// Flags, stuffing and checksum. A frame's content comes without its checksum. One 7E may end a
/// frame and begin the next. Fewer than three bytes between two 7E are dropped unsaid: RS-485
/// adapters put NULs there.
struct Framing {
  static constexpr std::size_t kLongest = 512;

  Cut cut(Bytes window, ByteBuffer& frame) const;
};

/// Replaces `out` by the frame of `content` on the wire.
void encodeFrame(Bytes content, ByteBuffer& out);

// === Commands

/// What six numbers of a command are. The header is this with the wished reply in its low bits.
enum class Mode : std::uint8_t {
  kPosition = 0x10,
  kVelocity = 0x20,
  kTorque = 0x30,
  kVoltage = 0x40,
  kReadOnly = 0xA0,  ///< none; keeps the API mode alive, but does not enter it
};

/// Which reply a command asks for.
enum class Reply : std::uint8_t {
  kTouchCurrent = 0,   ///< variant 1: positions, currents, touch
  kTouchVelocity = 1,  ///< variant 2: positions, velocities, touch
  kMotors = 2,         ///< variant 3: positions, currents, velocities
};

enum class Simple : std::uint8_t {
  kExitApi = 0x7C,  ///< back to the hand's own control
  kUpsampleThumbOn = 0xC2,
  kUpsampleThumbOff = 0xC3,
};

/// Errors: BrokenContract for `kReadOnly`, and for counts of -32768, which the hand must never
/// be sent.
void encodeCommand(
    std::uint8_t address, Mode mode, Reply reply, const Counts& counts, ByteBuffer& out);
void encodeReadOnly(std::uint8_t address, Reply reply, ByteBuffer& out);
void encodeSimple(std::uint8_t address, Simple command, ByteBuffer& out);
/// `speed` 0 stops, 1..254 closes in 2 s..0.29 s, 255 in 0.2 s.
void encodeGrip(std::uint8_t address, std::uint8_t grip, std::uint8_t speed, ByteBuffer& out);
void encodeReadRegister(std::uint8_t address, std::uint32_t number, ByteBuffer& out);
void encodeWriteRegister(std::uint8_t address,
                         std::uint32_t number,
                         std::uint32_t value,
                         ByteBuffer& out);

/// A command as the hand understands it. `header` says which.
struct Command {
  std::uint8_t address = 0;
  std::uint8_t header = 0;
  std::optional<Counts> counts;  ///< of position, velocity, torque and voltage commands

  [[nodiscard]] Mode mode() const { return static_cast<Mode>(header & 0xF0); }

  [[nodiscard]] Reply reply() const { return static_cast<Reply>(header & 0x0F); }
};

/// The command in a frame's content: motor commands, read-only and simple ones; none otherwise.
std::optional<Command> commandOf(Bytes content);

// === Replies

/// What the hand measured. `reply` says which of the arrays hold something; the others are 0.
struct State {
  Reply reply = Reply::kMotors;
  std::uint8_t header = 0;  ///< that of the command it answers
  Counts position{};
  Counts current{};
  Counts velocity{};                               ///< of the rotor
  std::array<std::uint16_t, kTouchCount> touch{};  ///< 12 bits each
  /// Bit i: motor i is held back, since it is hot or met an obstacle, and does not obey.
  std::uint8_t limited = 0;
};

/// The reply in a frame's content; none if length or header fit no reply.
std::optional<State> stateOf(Bytes content);

/// A reply's bytes on the wire, for devices.
void encodeState(const State& state, ByteBuffer& out);

// === Units

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kRadPerCount = 150.0 / 32767.0 * kPi / 180.0;
inline constexpr double kAmperePerCount = 1.0 / 620.606079;  ///< of current boards
inline constexpr double kRotorRadPerSecondPerCount = 0.25;
/// Turns of the rotor for one of the joint. Differs: the vendor's wrappers scale all velocities
/// alike, which is wrong for the rotator by a factor of 3.9.
inline constexpr std::array<double, kMotorCount> kGearRatio = {649.0, 649.0, 649.0,
                                                               649.0, 649.0, 162.45};
inline constexpr std::int16_t kLargestCount = 32767;
inline constexpr std::int16_t kLargestVoltage = 3546;  ///< full duty

/// `value` in counts of `per_count`, cut towards zero as the vendor does, at most `largest`
/// either way. Errors: BrokenContract if it is not finite.
std::int16_t countsOf(double value, double per_count, std::int16_t largest = kLargestCount);

/// Newton, uncalibrated, of a 12-bit touch reading; 0 for 0.
double touchForce(std::uint16_t reading);

}  // namespace handgraft::protocols::ability_hand
