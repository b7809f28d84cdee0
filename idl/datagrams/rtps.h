#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The wire of RTPS 2.x, as far as the filter reads it (OMG formal/2019-04-03, chapter and
/// verse with each).
namespace handgraft::idl::rtps {

using Bytes = std::span<const std::uint8_t>;

inline constexpr std::size_t kMessageHeader = 20;
inline constexpr std::size_t kSubmessageHeader = 4;

// Kinds of submessages, 9.4.5.1.1.
inline constexpr std::uint8_t kPad = 0x01;
inline constexpr std::uint8_t kAckNack = 0x06;
inline constexpr std::uint8_t kHeartbeat = 0x07;
inline constexpr std::uint8_t kGap = 0x08;
inline constexpr std::uint8_t kInfoTimestamp = 0x09;
inline constexpr std::uint8_t kInfoSource = 0x0c;
inline constexpr std::uint8_t kInfoDestination = 0x0e;
inline constexpr std::uint8_t kNackFragment = 0x12;
inline constexpr std::uint8_t kHeartbeatFragment = 0x13;
inline constexpr std::uint8_t kData = 0x15;
inline constexpr std::uint8_t kDataFragment = 0x16;
// Of DDS Security 1.1, 7.3.6.2: these three stand for one that is encrypted.
inline constexpr std::uint8_t kSecureBody = 0x30;
inline constexpr std::uint8_t kSecurePrefix = 0x31;
inline constexpr std::uint8_t kSecurePostfix = 0x32;

// Flags of DATA, 9.4.5.3.
inline constexpr std::uint8_t kLittleEndian = 0x01;
inline constexpr std::uint8_t kInlineQos = 0x02;
inline constexpr std::uint8_t kHasData = 0x04;
inline constexpr std::uint8_t kHasKey = 0x08;
inline constexpr std::uint8_t kFinal = 0x02;  // of ACKNACK and HEARTBEAT

// Builtin writers, 9.3.1.5.
inline constexpr std::uint32_t kParticipantWriter = 0x000100c2;
inline constexpr std::uint32_t kPublicationsWriter = 0x000003c2;
inline constexpr std::uint32_t kSubscriptionsWriter = 0x000004c2;
// DDS-XTypes 1.3, 7.6.3.3.3: who asks for types, who tells.
inline constexpr std::uint32_t kTypeRequestWriter = 0x000300c3;
inline constexpr std::uint32_t kTypeReplyWriter = 0x000301c3;
inline constexpr std::uint32_t kBuiltin = 0xc0;  // in the entity's kind
inline constexpr std::uint32_t kParticipantReader = 0x000100c7;
// Of handshakes, DDS Security 1.1, 7.4.7.1.
inline constexpr std::uint32_t kHandshakeWriter = 0x000201c3;
inline constexpr std::uint32_t kHandshakeReader = 0x000201c4;

// Parameters, 9.6.2.2.2.
inline constexpr std::uint16_t kSentinel = 0x0001;
inline constexpr std::uint16_t kLease = 0x0002;
inline constexpr std::uint16_t kParticipantGuid = 0x0050;
inline constexpr std::uint16_t kEntityName = 0x0062;
inline constexpr std::uint16_t kStatusInfo = 0x0071;
inline constexpr std::uint16_t kTypeInformation = 0x0075;
inline constexpr std::uint16_t kIdentityToken = 0x1001;
inline constexpr std::uint16_t kPermissionsToken = 0x1002;
inline constexpr std::uint32_t kEternal = 0x7fffffff;  // s

/// Numbers at places of a piece; a place beyond its end is noticed by `fits`.
struct Piece {
  Bytes bytes;
  bool little = true;

  [[nodiscard]] bool fits(std::size_t at, std::size_t count) const {
    return at <= bytes.size() && count <= bytes.size() - at;
  }

  [[nodiscard]] std::uint16_t u16(std::size_t at) const {
    return static_cast<std::uint16_t>(number(at, 2));
  }

  [[nodiscard]] std::uint32_t u32(std::size_t at) const { return number(at, 4); }

  /// An entity's id is in the order of the wire, whatever the flag says.
  [[nodiscard]] std::uint32_t entity(std::size_t at) const {
    return Piece{bytes, false}.number(at, 4);
  }

  [[nodiscard]] std::int64_t sequence(std::size_t at) const {
    return static_cast<std::int64_t>(std::uint64_t{u32(at)} << 32U | u32(at + 4));
  }

  [[nodiscard]] Piece from(std::size_t at) const { return {bytes.subspan(at), little}; }

 private:
  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t shift = 8 * (little ? i : size - 1 - i);
      value |= std::uint32_t{bytes[at + i]} << shift;
    }
    return value;
  }
};

/// Calls `look(id, value)`, which may object, for each parameter; nothing if the list is
/// malformed or was objected to, else where it ends.
template <class Look>
std::optional<std::size_t> parameters(const Piece& list, const Look& look) {
  for (std::size_t at = 0; list.fits(at, 4);) {
    const std::uint16_t id = list.u16(at);
    const std::uint16_t length = list.u16(at + 2);
    at += 4;
    if (id == kSentinel) return at;
    if (!list.fits(at, length)) return std::nullopt;
    if (!look(id, Piece{list.bytes.subspan(at, length), list.little})) return std::nullopt;
    at += length;
  }
  return std::nullopt;
}

/// The bytes of a set of numbers with its bitmap at `at`, or nothing if it is malformed.
inline std::optional<std::size_t> setLength(const Piece& body,
                                            std::size_t at,
                                            std::size_t base_bytes) {
  if (!body.fits(at, base_bytes + 4)) return std::nullopt;
  const std::uint32_t bits = body.u32(at + base_bytes);
  if (bits > 256) return std::nullopt;
  const std::size_t length = base_bytes + 4 + std::size_t{4} * ((bits + 31) / 32);
  if (!body.fits(at, length)) return std::nullopt;
  return length;
}

/// A multiple of four from `at` on.
constexpr std::size_t aligned(std::size_t at) {
  return (at + 3) & ~std::size_t{3};
}

}  // namespace handgraft::idl::rtps
