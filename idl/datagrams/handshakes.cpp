#include "idl/datagrams/handshakes.h"

namespace handgraft::idl::rtps {
namespace {

constexpr std::uint32_t kMostProperties = 64;
constexpr std::uint32_t kMostTokens = 4;  // of one handshake message

/// Where the string, or the sequence of octets, at `at` ends.
std::optional<std::size_t> endOfText(const Piece& list, std::size_t at) {
  at = aligned(at);
  if (!list.fits(at, 4)) return std::nullopt;
  const std::size_t length = list.u32(at);
  if (!list.fits(at + 4, length)) return std::nullopt;
  return at + 4 + length;
}

/// Where the DataHolder at `at` ends: a class, properties, binary properties (which an identity
/// token may leave out).
std::optional<std::size_t> endOfToken(const Piece& list, std::size_t at) {
  auto end = endOfText(list, at);
  for (int kind = 0; end && kind < 2; ++kind) {
    at = aligned(*end);
    if (at == list.bytes.size() && kind == 1) return at;
    if (!list.fits(at, 4)) return std::nullopt;
    const std::uint32_t count = list.u32(at);
    if (count > kMostProperties) return std::nullopt;
    end = at + 4;
    for (std::uint32_t i = 0; end && i < 2 * count; ++i)  // names and values
      end = endOfText(list, *end);
  }
  return end;
}

}  // namespace

bool hasSoundTokens(const Piece& list) {
  return parameters(list,
                    [](std::uint16_t id, const Piece& value) {
                      if (id == kLease) return value.fits(0, 8) && value.u32(0) < kEternal;
                      if (id == kIdentityToken || id == kPermissionsToken)
                        return endOfToken(value, 0).has_value();
                      return true;
                    })
      .has_value();
}

bool isHandshake(const Piece& message) {
  // Two messages' identities, then a participant's and two endpoints' GUIDs.
  constexpr std::size_t kFixed = 24 + 24 + 16 + 16 + 16;
  if (!message.fits(0, kFixed)) return false;
  const auto end = endOfText(message, kFixed);
  if (!end) return false;
  std::size_t at = aligned(*end);
  if (!message.fits(at, 4)) return false;
  const std::uint32_t count = message.u32(at);
  if (count > kMostTokens) return false;
  at += 4;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto next = endOfToken(message, at);
    if (!next) return false;
    at = *next;
  }
  return true;
}

bool isPlainSample(const Piece& body, std::uint8_t flags) {
  if ((flags & (kHasData | kHasKey)) != kHasData) return false;
  if ((flags & kInlineQos) == 0) return true;
  const std::size_t at = 4 + std::size_t{body.u16(2)};
  return body.fits(at, 0) && parameters(body.from(at), [](std::uint16_t id, const Piece&) {
                               return id != kStatusInfo;
                             }).has_value();
}

}  // namespace handgraft::idl::rtps
