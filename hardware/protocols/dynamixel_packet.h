#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hardware/protocols/bytes.h"
#include "hardware/protocols/stream_reader.h"

/// Packets of Dynamixel Protocol 2.0.
///
/// On the wire: FF FF FD 00, id, length (2), instruction, parameters, CRC (2); numbers low byte
/// first. Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
namespace handgraft::protocols::dynamixel {

inline constexpr std::uint8_t kBroadcastId = 0xFE;
inline constexpr std::uint8_t kHighestId = 0xFC;

enum class Instruction : std::uint8_t {
  kPing = 0x01,
  kRead = 0x02,
  kWrite = 0x03,
  kRegWrite = 0x04,
  kAction = 0x05,
  kFactoryReset = 0x06,
  kReboot = 0x08,
  kClear = 0x10,
  kStatus = 0x55,
  kSyncRead = 0x82,
  kSyncWrite = 0x83,
  kFastSyncRead = 0x8A,
  kBulkRead = 0x92,
  kBulkWrite = 0x93,
};

/// Why an instruction was not done; the low seven bits of a status packet's error byte.
enum class Error : std::uint8_t {
  kNone = 0,
  kResultFail = 1,
  kInstruction = 2,
  kCrc = 3,
  kDataRange = 4,
  kDataLength = 5,
  kDataLimit = 6,
  kAccess = 7,  ///< read-only, no such address, or EEPROM while the torque is on
};

/// CRC-16/UMTS: polynomial 0x8005, start 0, not reflected.
[[nodiscard]] std::uint16_t crc16(Bytes bytes);

/// A packet without its frame: what `Framing` finds and `encode` writes. `parameters` looks
/// into somebody else's bytes.
struct Packet {
  std::uint8_t id = 0;
  std::uint8_t instruction = 0;
  Bytes parameters;
};

/// Header, length, byte stuffing and CRC. A frame's content is id, instruction, parameters.
/// Accepts what `encode` can write and nothing else: a packet whose stuffing is missing is
/// damaged, whatever its CRC.
struct Framing {
  static constexpr std::size_t kLongest = ByteBuffer::kCapacity;

  Cut cut(Bytes window, ByteBuffer& frame) const;
};

/// A frame's content as a packet. Errors: BrokenContract if it is none that `Framing` found.
[[nodiscard]] Packet packetOf(Bytes frame);

/// Replaces `out` by the packet's bytes on the wire.
/// Errors: BrokenContract if it does not fit.
void encode(const Packet& packet, ByteBuffer& out);

/// A device's reply.
struct Status {
  std::uint8_t id = 0;
  bool alert = false;  ///< the device has a hardware error; its register 70 says which
  Error error = Error::kNone;
  Bytes data;  ///< looks into the packet's bytes
};

/// The reply in a packet; none if it is no reply of one device.
[[nodiscard]] std::optional<Status> statusOf(const Packet& packet);

/// A reply's bytes on the wire, for devices.
void encodeStatus(const Status& status, ByteBuffer& out);

// === Instructions; each replaces `out` by its bytes on the wire

void encodePing(std::uint8_t id, ByteBuffer& out);
void encodeReboot(std::uint8_t id, ByteBuffer& out);
void encodeRead(std::uint8_t id, std::uint16_t address, std::uint16_t size, ByteBuffer& out);
void encodeWrite(std::uint8_t id, std::uint16_t address, Bytes data, ByteBuffer& out);

/// Every id answers with its own status, in this order.
void encodeSyncRead(std::uint16_t address,
                    std::uint16_t size,
                    std::span<const std::uint8_t> ids,
                    ByteBuffer& out);

/// `data` holds `size` bytes per id, one id after the other. Nobody answers.
/// Errors: BrokenContract if it does not.
void encodeSyncWrite(std::uint16_t address,
                     std::uint16_t size,
                     std::span<const std::uint8_t> ids,
                     Bytes data,
                     ByteBuffer& out);

}  // namespace handgraft::protocols::dynamixel
