#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hardware/protocols/bytes.h"
#include "hardware/protocols/stream_reader.h"

/// Modbus RTU: 16-bit registers of a device on a serial line, high byte first, CRC-16 low byte
/// first. Two functions are all we need: read holding registers (3), write multiple registers
/// (16). Source: "MODBUS over serial line", specification and implementation guide V1.02.
namespace handgraft::protocols::modbus {

inline constexpr std::uint8_t kReadRegisters = 0x03;
inline constexpr std::uint8_t kWriteRegisters = 0x10;
inline constexpr std::uint8_t kException = 0x80;   ///< added to a function that failed
inline constexpr std::size_t kMostRegisters = 32;  ///< in one frame of ours

/// Polynomial 0xA001 (reflected 0x8005), from 0xFFFF.
std::uint16_t crcOf(Bytes bytes);

// === To the device

void encodeRead(std::uint8_t device,
                std::uint16_t address,
                std::uint16_t count,
                ByteBuffer& out);
void encodeWrite(std::uint8_t device,
                 std::uint16_t address,
                 std::span<const std::uint16_t> values,
                 ByteBuffer& out);

struct Request {
  std::uint8_t device = 0;
  std::uint8_t function = 0;
  std::uint16_t address = 0;
  std::uint16_t count = 0;
  Bytes values;  ///< of a write, high byte first
};

// === From the device

struct Reply {
  std::uint8_t device = 0;
  std::uint8_t function = 0;  ///< with kException if it failed
  std::uint8_t exception = 0;
  std::uint16_t address = 0;  ///< of a write
  Bytes values;               ///< of a read, high byte first
};

/// A reply's or a request's bytes without CRC; the content of a frame.
std::optional<Reply> replyOf(Bytes content);
std::optional<Request> requestOf(Bytes content);

void encodeReadReply(std::uint8_t device,
                     std::span<const std::uint16_t> values,
                     ByteBuffer& out);
void encodeWriteReply(std::uint8_t device,
                      std::uint16_t address,
                      std::uint16_t count,
                      ByteBuffer& out);

/// The register at `index`.
std::uint16_t registerAt(Bytes values, std::size_t index);

/// What a device says. Modbus marks frames by pauses, which a tty does not tell: here a frame's
/// own function and length say how long it is, and its CRC whether it was one.
struct ReplyFraming {
  static constexpr std::size_t kLongest = 128;

  Cut cut(Bytes window, ByteBuffer& frame) const;
};

/// What a device hears.
struct RequestFraming {
  static constexpr std::size_t kLongest = 128;

  Cut cut(Bytes window, ByteBuffer& frame) const;
};

}  // namespace handgraft::protocols::modbus
