#include "idl/datagrams/submessages.h"

#include <algorithm>
#include <string_view>

#include "idl/datagrams/datagram_filter.h"

namespace handgraft::idl::rtps {
namespace {

/// A participant may speak for itself alone, and must be missed no sooner than ours are.
bool isAnnouncement(const Piece& list, Bytes source) {
  bool is_own = false;
  const auto end = parameters(list, [&](std::uint16_t id, const Piece& value) {
    if (id == kParticipantGuid) {
      is_own =
          value.fits(0, 16) && std::equal(source.begin(), source.end(), value.bytes.begin());
      return is_own;
    }
    if (id == kLease) return value.fits(0, 8) && value.u32(0) >= DatagramFilter::kShortestLease;
    return true;
  });
  return end && is_own;
}

}  // namespace

bool isPassed(std::uint8_t kind) {
  switch (kind) {
    case kPad:
    case kAckNack:
    case kHeartbeat:
    case kGap:
    case kInfoTimestamp:
    case kInfoSource:
    case kInfoDestination:
    case kNackFragment:
    case kHeartbeatFragment:
    case kData:
    case kDataFragment:
      return true;
    default:
      return false;
  }
}

std::optional<std::size_t> payloadOf(const Piece& body, std::uint8_t flags, std::size_t fixed) {
  if (!body.fits(0, fixed)) return std::nullopt;
  std::size_t at = 4 + std::size_t{body.u16(2)};  // octetsToInlineQos
  if (at < fixed || !body.fits(at, 0)) return std::nullopt;
  if ((flags & kInlineQos) != 0) {
    const auto length = parameters(body.from(at), [](std::uint16_t, const Piece&) {
      return true;
    });
    if (!length) return std::nullopt;
    at += *length;
  }
  return at;
}

bool isData(const Piece& body, std::uint8_t flags, Bytes source) {
  const auto at = payloadOf(body, flags, 20);
  if (!at) return false;
  if ((flags & (kHasData | kHasKey)) == 0) return true;
  if (!body.fits(*at, 4)) return false;
  const std::uint32_t writer = body.entity(8);
  // A parameter list of either byte order, 10.2.
  const Piece list{body.bytes.subspan(*at + 4), body.bytes[*at + 1] % 2 == 1};
  const bool is_discovery = writer == kParticipantWriter || writer == kPublicationsWriter ||
                            writer == kSubscriptionsWriter;
  if (writer == kParticipantWriter && (flags & kHasData) != 0)
    return isAnnouncement(list, source);
  if (is_discovery) {
    return parameters(list,
                      [](std::uint16_t, const Piece&) {
                        return true;
                      })
        .has_value();
  }
  return true;
}

bool announcesAClient(const Piece& body, std::uint8_t flags) {
  constexpr std::string_view kName = DatagramFilter::kClient;
  const auto at = payloadOf(body, flags, 20);
  if (!at || (flags & kHasData) == 0 || !body.fits(*at, 4) ||
      body.entity(8) != kParticipantWriter)
    return false;
  bool is_client = false;
  const Piece list{body.bytes.subspan(*at + 4), body.bytes[*at + 1] % 2 == 1};
  parameters(list, [&](std::uint16_t id, const Piece& value) {
    if (id != kEntityName) return true;
    is_client = value.fits(0, 4 + kName.size() + 1) && value.u32(0) == kName.size() + 1 &&
                std::equal(kName.begin(), kName.end(), value.bytes.begin() + 4);
    return false;
  });
  return is_client;
}

bool isDataFragment(const Piece& body, std::uint8_t flags) {
  const auto at = payloadOf(body, flags, 32);
  if (!at) return false;
  const std::uint32_t first = body.u32(20);
  const std::uint32_t count = body.u16(24);
  const std::uint32_t size = body.u16(26);
  const std::uint32_t whole = body.u32(28);
  if (first == 0 || count == 0 || size == 0 || whole > DatagramFilter::kLargestSample)
    return false;
  const std::uint32_t fragments = (whole + size - 1) / size;
  if (first > fragments || count > fragments - first + 1) return false;
  // The last one may be shorter.
  const std::uint64_t begin = std::uint64_t{first - 1} * size;
  const std::uint64_t end = std::min<std::uint64_t>(begin + std::uint64_t{count} * size, whole);
  return body.fits(*at, static_cast<std::size_t>(end - begin));
}

/// A reader that has just matched asks what there is. Cyclone DDS counts that question as its
/// 0th and asks from number 1 on; Fast DDS takes no 0th for a new one, and answers by its next
/// heartbeat, up to a second later. Counted from 1 and asked from number 0 on, as its own
/// readers ask, it is answered at once. So all counts are one higher, and an empty question
/// begins at 0.
void beginAnew(std::span<std::uint8_t> whole) {
  const bool little = (whole[1] & kLittleEndian) != 0;
  const auto body = whole.subspan(kSubmessageHeader);
  const Piece read{body, little};
  const std::size_t count_at = 8 + setLength(read, 8, 8).value();
  const std::uint32_t count = read.u32(count_at) + 1;
  for (std::size_t i = 0; i < 4; ++i)
    body[count_at + i] = static_cast<std::uint8_t>(count >> (8 * (little ? i : 3 - i)));
  const bool asks = (whole[1] & kFinal) == 0 && read.sequence(8) == 1 && read.u32(16) == 0;
  if (asks && (read.entity(4) & kBuiltin) == kBuiltin)
    std::fill_n(body.begin() + 8, 8, std::uint8_t{0});
}

void blankTypes(std::span<std::uint8_t> whole) {
  const bool little = (whole[1] & kLittleEndian) != 0;
  const Piece body{whole.subspan(kSubmessageHeader), little};
  const std::uint32_t writer = body.entity(8);
  if ((whole[1] & (kHasData | kHasKey)) == 0 ||
      (writer != kParticipantWriter && writer != kPublicationsWriter &&
       writer != kSubscriptionsWriter))
    return;
  const std::size_t at = kSubmessageHeader + payloadOf(body, whole[1], 20).value();
  const Piece list{whole.subspan(at + 4), whole[at + 1] % 2 == 1};
  parameters(list, [&](std::uint16_t id, const Piece& value) {
    if (id == kTypeInformation) {
      // The id stands before the length, and that before the value.
      const std::size_t id_at = static_cast<std::size_t>(value.bytes.data() - whole.data()) - 4;
      whole[id_at] = whole[id_at + 1] = 0;
    }
    return true;
  });
}

}  // namespace handgraft::idl::rtps
