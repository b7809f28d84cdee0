#include "idl/datagrams/datagram_filter.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "idl/datagrams/shown_certificate.h"

namespace handgraft::idl {

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kMessageHeader = 20;
constexpr std::size_t kSubmessageHeader = 4;

// Kinds of submessages, 9.4.5.1.1.
constexpr std::uint8_t kPad = 0x01;
constexpr std::uint8_t kAckNack = 0x06;
constexpr std::uint8_t kHeartbeat = 0x07;
constexpr std::uint8_t kGap = 0x08;
constexpr std::uint8_t kInfoTimestamp = 0x09;
constexpr std::uint8_t kInfoSource = 0x0c;
constexpr std::uint8_t kInfoDestination = 0x0e;
constexpr std::uint8_t kNackFragment = 0x12;
constexpr std::uint8_t kHeartbeatFragment = 0x13;
constexpr std::uint8_t kData = 0x15;
constexpr std::uint8_t kDataFragment = 0x16;
// Of DDS Security 1.1, 7.3.6.2: these three stand for one that is encrypted.
constexpr std::uint8_t kSecureBody = 0x30;
constexpr std::uint8_t kSecurePrefix = 0x31;
constexpr std::uint8_t kSecurePostfix = 0x32;

// Flags of DATA, 9.4.5.3.
constexpr std::uint8_t kLittleEndian = 0x01;
constexpr std::uint8_t kInlineQos = 0x02;
constexpr std::uint8_t kHasData = 0x04;
constexpr std::uint8_t kHasKey = 0x08;
constexpr std::uint8_t kFinal = 0x02;  // of ACKNACK and HEARTBEAT

// Builtin writers, 9.3.1.5.
constexpr std::uint32_t kParticipantWriter = 0x000100c2;
constexpr std::uint32_t kPublicationsWriter = 0x000003c2;
constexpr std::uint32_t kSubscriptionsWriter = 0x000004c2;
// DDS-XTypes 1.3, 7.6.3.3.3: who asks for types, who tells.
constexpr std::uint32_t kTypeRequestWriter = 0x000300c3;
constexpr std::uint32_t kTypeReplyWriter = 0x000301c3;
constexpr std::uint32_t kBuiltin = 0xc0;  // in the entity's kind
constexpr std::uint32_t kParticipantReader = 0x000100c7;
// Of handshakes, DDS Security 1.1, 7.4.7.1.
constexpr std::uint32_t kHandshakeWriter = 0x000201c3;
constexpr std::uint32_t kHandshakeReader = 0x000201c4;

// Parameters, 9.6.2.2.2.
constexpr std::uint16_t kSentinel = 0x0001;
constexpr std::uint16_t kLease = 0x0002;
constexpr std::uint16_t kParticipantGuid = 0x0050;
constexpr std::uint16_t kEntityName = 0x0062;
constexpr std::uint16_t kStatusInfo = 0x0071;
constexpr std::uint16_t kTypeInformation = 0x0075;
constexpr std::uint16_t kIdentityToken = 0x1001;
constexpr std::uint16_t kPermissionsToken = 0x1002;
constexpr std::uint32_t kEternal = 0x7fffffff;  // s

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
std::optional<std::size_t> setLength(const Piece& body,
                                     std::size_t at,
                                     std::size_t base_bytes) {
  if (!body.fits(at, base_bytes + 4)) return std::nullopt;
  const std::uint32_t bits = body.u32(at + base_bytes);
  if (bits > 256) return std::nullopt;
  const std::size_t length = base_bytes + 4 + 4 * ((bits + 31) / 32);
  if (!body.fits(at, length)) return std::nullopt;
  return length;
}

}  // namespace

struct DatagramFilter::Submessage {
  std::uint8_t kind;
  std::uint8_t flags;
  Bytes whole;  ///< with its header

  [[nodiscard]] Piece body() const {
    return {whole.subspan(kSubmessageHeader), (flags & kLittleEndian) != 0};
  }
};

namespace {

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

/// A participant may speak for itself alone, and must be missed no sooner than ours are.
bool isAnnouncement(const Piece& list, Bytes source) {
  bool is_own = false;
  const auto end = parameters(list, [&](std::uint16_t id, const Piece& value) {
    if (id == kParticipantGuid) {
      is_own =
          value.fits(0, 16) && std::equal(source.begin(), source.end(), value.bytes.begin());
      return is_own;
    }
    if (id == kLease)
      return value.fits(0, 8) && value.u32(0) >= DatagramFilter::kShortestLease_s;
    return true;
  });
  return end && is_own;
}

/// Where what was written of DATA begins; nothing if what stands before it is malformed.
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

/// DATA of any shape.
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

/// Type information becomes padding: types meet by name alone. `whole`: DATA that is sound.
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

// === In a secured domain
//
// Every length in a token must fit: Fast DDS 2.9.1 allocates what a sender says (CVE-2025-62599
// and those after it).

constexpr std::uint32_t kMostProperties = 64;
constexpr std::uint32_t kMostTokens = 4;  // of one handshake message

constexpr std::size_t aligned(std::size_t at) {
  return (at + 3) & ~std::size_t{3};
}

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

/// A ParticipantGenericMessage.
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

/// True of what writes or disposes otherwise than by a whole sample: nobody leaves, or is made
/// to leave, in the clear.
bool isPlainSample(const Piece& body, std::uint8_t flags) {
  if ((flags & (kHasData | kHasKey)) != kHasData) return false;
  if ((flags & kInlineQos) == 0) return true;
  const std::size_t at = 4 + std::size_t{body.u16(2)};
  return body.fits(at, 0) && parameters(body.from(at), [](std::uint16_t id, const Piece&) {
                               return id != kStatusInfo;
                             }).has_value();
}

}  // namespace

DatagramFilter::GuidBegin DatagramFilter::beginOf(const Prefix& source) {
  GuidBegin begin;
  std::copy_n(source.begin(), begin.size(), begin.begin());
  return begin;
}

bool DatagramFilter::isAsBefore(const Prefix& source, Bytes announcement) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes, to be compared
  const std::string_view text(reinterpret_cast<const char*>(announcement.data()),
                              announcement.size());
  const std::size_t hash = std::hash<std::string_view>()(text);
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  const auto found = announced_.find(source);
  if (found != announced_.end()) {
    Announced& known = found->second;
    if (known.hash != hash && now - known.last < kRemembered) return false;
    known = {hash, now};
    return true;
  }
  if (announced_.size() >= kMostParticipants) {
    std::erase_if(announced_, [&](const auto& one) {
      return now - one.second.last >= kRemembered;
    });
    // Whom a flood would drive out could be spoken for by it: nobody new then.
    if (announced_.size() >= kMostParticipants) return false;
  }
  announced_[source] = {hash, now};
  return true;
}

bool DatagramFilter::isHandshakeOrAnnouncement(const Prefix& source,
                                               const Submessage& submessage) {
  const Piece body = submessage.body();
  if (!isSound(source, submessage) || !isPlainSample(body, submessage.flags)) return false;
  const std::uint32_t reader = body.entity(4);
  const std::uint32_t writer = body.entity(8);
  const std::size_t at = payloadOf(body, submessage.flags, 20).value();
  const Piece payload{body.bytes.subspan(at + 4), body.bytes[at + 1] % 2 == 1};
  if (writer == kParticipantWriter && (reader == kParticipantReader || reader == 0))
    return hasSoundTokens(payload) && isAsBefore(source, payload.bytes);
  if (writer != kHandshakeWriter || (reader != kHandshakeReader && reader != 0)) return false;
  if (!isHandshake(payload)) return false;
  if (on_certificate_) {
    const auto shown = shownCertificate(payload.bytes, payload.little);
    if (!shown.empty()) on_certificate_(beginOf(source), shown);
  }
  return true;
}

std::optional<std::vector<std::uint8_t>> DatagramFilter::wholeHandshake(
    const Prefix& source, const Submessage& fragment) {
  const Piece body = fragment.body();
  if (!isDataFragment(body, fragment.flags) || body.entity(8) != kHandshakeWriter)
    return std::nullopt;
  const std::size_t at = payloadOf(body, fragment.flags, 32).value();
  std::optional<std::vector<std::uint8_t>> sample;
  {
    const std::lock_guard lock(mutex_);
    sample = handshakes_.add({source, body.sequence(12), body.u32(20), body.u16(26),
                              body.u32(28), body.bytes.subspan(at)});
  }
  if (!sample) return std::nullopt;
  // 9.4.5.3: flags and where the sample begins; reader, writer and number are the fragment's.
  constexpr std::size_t kFixed = 20;
  constexpr std::uint8_t kToSample = 16;
  const std::size_t length = kFixed + sample->size();
  const std::uint8_t little = fragment.flags & kLittleEndian;
  const auto low = static_cast<std::uint8_t>(length);
  const auto high = static_cast<std::uint8_t>(length >> 8U);
  std::vector<std::uint8_t> made{kData, static_cast<std::uint8_t>(little | kHasData)};
  if (little != 0)
    made.insert(made.end(), {low, high, 0, 0, kToSample, 0});
  else
    made.insert(made.end(), {high, low, 0, 0, 0, kToSample});
  made.insert(made.end(), body.bytes.begin() + 4, body.bytes.begin() + kFixed);
  made.insert(made.end(), sample->begin(), sample->end());
  return made;
}

void DatagramFilter::refuse(std::set<GuidBegin> whom) {
  const std::lock_guard lock(mutex_);
  refused_ = std::move(whom);
  refuses_ = !refused_.empty();
}

bool DatagramFilter::isRefused(const Prefix& source) {
  if (!refuses_) return false;
  const std::lock_guard lock(mutex_);
  return refused_.count(beginOf(source)) != 0;
}

bool DatagramFilter::isWithinShare(const Prefix& source, const Submessage& submessage) {
  if (reader_ != Reader::kFastDds || submessage.kind != kData) return true;
  if ((submessage.body().entity(8) & kBuiltin) == kBuiltin) return true;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  if (shares_.size() >= kMostParticipants && shares_.count(source) == 0) shares_.clear();
  return shares_[source].take(kSamplesPerSecond, kSamplesAtOnce, now) ||
         shared_.take(kSharedPerSecond, kSharedAtOnce, now);
}

bool DatagramFilter::Share::take(double per_second,
                                 double at_once,
                                 std::chrono::steady_clock::time_point now) {
  const std::chrono::duration<double> since = now - std::exchange(last, now);
  samples = std::min(at_once, samples + per_second * since.count());
  if (samples < 1.0) return false;
  samples -= 1.0;
  return true;
}

bool DatagramFilter::isKeptFrom(const Submessage& submessage) const {
  if (reader_ == Reader::kFastDds) return false;
  const Piece body = submessage.body();
  switch (submessage.kind) {
    case kHeartbeat:
    case kHeartbeatFragment:
    case kGap: {
      const std::uint32_t writer = body.entity(4);
      return writer == kTypeRequestWriter || writer == kTypeReplyWriter;
    }
    case kData: {
      const std::uint32_t writer = body.entity(8);
      return writer == kTypeRequestWriter || writer == kTypeReplyWriter;
    }
    case kDataFragment:
      return (body.entity(8) & kBuiltin) == kBuiltin;
    default:
      return false;
  }
}

std::optional<std::size_t> DatagramFilter::secured(const Prefix& source,
                                                   const Submessage& submessage,
                                                   Bytes rest) {
  const std::size_t own = submessage.whole.size();
  switch (submessage.kind) {
    case kInfoTimestamp:
    case kInfoSource:
    case kInfoDestination:
      if (!isSound(source, submessage)) return std::nullopt;
      return own;
    case kData:
      return isHandshakeOrAnnouncement(source, submessage) ? own : 0;
    case kSecurePrefix: {
      std::size_t length = own;
      for (const std::uint8_t kind : {kSecureBody, kSecurePostfix}) {
        const auto next = submessageAt(rest);
        if (!next || next->kind != kind) return std::nullopt;
        length += next->whole.size();
        rest = rest.subspan(next->whole.size());
      }
      return length;
    }
    default:
      return 0;
  }
}

std::optional<DatagramFilter::Submessage> DatagramFilter::submessageAt(Bytes rest) {
  if (rest.size() < kSubmessageHeader) return std::nullopt;
  const std::uint8_t kind = rest[0];
  const std::uint8_t flags = rest[1];
  std::size_t length = Piece{rest, (flags & kLittleEndian) != 0}.u16(2);
  // 9.4.5.1.3: the last one may leave its length out, where it may not be empty.
  if (length == 0 && kind != kPad && kind != kInfoTimestamp)
    length = rest.size() - kSubmessageHeader;
  if (length > rest.size() - kSubmessageHeader) return std::nullopt;
  return Submessage{kind, flags, rest.first(kSubmessageHeader + length)};
}

bool DatagramFilter::follows(const Prefix& source,
                             std::uint32_t writer,
                             std::int64_t first,
                             std::int64_t last) {
  if (first < 1 || last < first - 1 || last - first >= kLongestRange) return false;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  forgetSilent(now);
  if (writers_ >= kMostWriters) {
    heard_.clear();
    writers_ = 0;
  }
  Heard& heard = heard_[source];
  heard.when = now;
  const auto [at, is_new] = heard.last.try_emplace(writer, 0);
  if (is_new) ++writers_;
  if (last - at->second > kLongestJump) return false;
  at->second = std::max(at->second, last);
  return true;
}

void DatagramFilter::forgetSilent(std::chrono::steady_clock::time_point now) {
  if (now - tidied_ < kRemembered) return;
  tidied_ = now;
  const auto is_silent = [now](std::chrono::steady_clock::time_point last) {
    return now - last > kWritersRemembered;
  };
  std::erase_if(heard_, [&](const auto& one) {
    return is_silent(one.second.when);
  });
  std::erase_if(shares_, [&](const auto& one) {
    return is_silent(one.second.last);
  });
  writers_ = 0;
  for (const auto& [source, heard] : heard_)
    writers_ += heard.last.size();
}

bool DatagramFilter::isSound(const Prefix& source, const Submessage& submessage) {
  const Piece body = submessage.body();
  switch (submessage.kind) {
    case kAckNack: {
      const auto set = setLength(body, 8, 8);
      return set && body.fits(8, *set + 4) && body.sequence(8) >= 0;
    }
    case kNackFragment: {
      const auto set = setLength(body, 16, 4);
      return set && body.fits(16, *set + 4) && body.sequence(8) >= 1;
    }
    case kHeartbeat:
      return body.fits(0, 28) &&
             follows(source, body.entity(4), std::max<std::int64_t>(1, body.sequence(8)),
                     body.sequence(16));
    case kHeartbeatFragment:
      return body.fits(0, 24) && body.u32(16) <= kLargestSample &&
             follows(source, body.entity(4), body.sequence(8), body.sequence(8));
    case kGap: {
      const auto set = setLength(body, 16, 8);
      return set && follows(source, body.entity(4), body.sequence(8), body.sequence(16));
    }
    case kInfoTimestamp:
      return (submessage.flags & 0x02) != 0 || body.fits(0, 8);
    case kInfoSource:  // unused, version, vendor, prefix
      return body.bytes.size() == 20 && body.bytes[4] == 2;
    case kInfoDestination:
      return body.fits(0, 12);
    case kData:
      return isData(body, submessage.flags, source) &&
             follows(source, body.entity(8), body.sequence(12), body.sequence(12));
    case kDataFragment:
      return isDataFragment(body, submessage.flags) &&
             follows(source, body.entity(8), body.sequence(12), body.sequence(12));
    default:
      return true;
  }
}

std::span<const std::uint8_t> DatagramFilter::pass(Bytes datagram,
                                                   std::vector<std::uint8_t>& kept) {
  constexpr std::array<std::uint8_t, 5> kProtocol{'R', 'T', 'P', 'S', 2};
  if (datagram.size() < kMessageHeader + kSubmessageHeader ||
      !std::equal(kProtocol.begin(), kProtocol.end(), datagram.begin()))
    return {};
  Prefix source;
  std::copy_n(datagram.begin() + 8, source.size(), source.begin());
  if (isRefused(source)) return {};

  kept.assign(datagram.begin(), datagram.begin() + kMessageHeader);
  bool has_content = false;  // beyond what says of whom and for whom the rest is
  for (Bytes rest = datagram.subspan(kMessageHeader); !rest.empty();) {
    const auto submessage = submessageAt(rest);
    if (!submessage) return {};
    const std::uint8_t kind = submessage->kind;
    std::size_t length = submessage->whole.size();
    if (kind == kData && passes_over_clients_ &&
        announcesAClient(submessage->body(), submessage->flags)) {
      // Left out.
    } else if (domain_ == Domain::kSecured && kind == kDataFragment) {
      const auto whole = wholeHandshake(source, *submessage);
      const auto handshake = whole ? submessageAt(*whole) : std::nullopt;
      if (handshake && isHandshakeOrAnnouncement(source, *handshake)) {
        has_content = true;
        kept.insert(kept.end(), whole->begin(), whole->end());
      }
    } else if (domain_ == Domain::kSecured) {
      const auto passed = secured(source, *submessage, rest.subspan(length));
      if (!passed) return {};
      if (*passed > 0) {
        length = *passed;
        has_content = has_content || kind == kData || kind == kSecurePrefix;
        const std::size_t at = kept.size();
        kept.insert(kept.end(), rest.begin(),
                    rest.begin() + static_cast<std::ptrdiff_t>(length));
        if (kind == kData && reader_ == Reader::kCyclone)
          blankTypes(std::span(kept).subspan(at));
      }
    } else if (isPassed(kind)) {
      if (!isSound(source, *submessage)) return {};
      if (!isKeptFrom(*submessage) && isWithinShare(source, *submessage)) {
        has_content = true;
        const std::size_t at = kept.size();
        kept.insert(kept.end(), submessage->whole.begin(), submessage->whole.end());
        const auto added = std::span(kept).subspan(at);
        if (kind == kAckNack && reader_ == Reader::kFastDds) beginAnew(added);
        if (kind == kData && reader_ == Reader::kCyclone) blankTypes(added);
      }
    }
    // Cyclone DDS packs what several participants of a process say: the rest is another's.
    if (kind == kInfoSource && submessage->whole.size() >= source.size()) {
      std::copy_n(submessage->whole.end() - std::ssize(source), source.size(), source.begin());
      if (isRefused(source)) return {};
    }
    rest = rest.subspan(length);
  }
  if (!has_content) return {};
  return kept;
}

}  // namespace handgraft::idl
