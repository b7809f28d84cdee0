#include "idl/datagrams/datagram_filter.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "idl/datagrams/handshakes.h"
#include "idl/datagrams/rtps.h"
#include "idl/datagrams/shown_certificate.h"
#include "idl/datagrams/submessages.h"

namespace handgraft::idl {

struct DatagramFilter::Submessage {
  std::uint8_t kind;
  std::uint8_t flags;
  rtps::Bytes whole;  ///< with its header

  [[nodiscard]] rtps::Piece body() const {
    return {whole.subspan(rtps::kSubmessageHeader), (flags & rtps::kLittleEndian) != 0};
  }
};

DatagramFilter::GuidBegin DatagramFilter::beginOf(const Prefix& source) {
  GuidBegin begin;
  std::copy_n(source.begin(), begin.size(), begin.begin());
  return begin;
}

bool DatagramFilter::isAsBefore(const Prefix& source, rtps::Bytes announcement) {
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
  const rtps::Piece body = submessage.body();
  if (!isSound(source, submessage) || !isPlainSample(body, submessage.flags)) return false;
  const std::uint32_t reader = body.entity(4);
  const std::uint32_t writer = body.entity(8);
  const std::size_t at = payloadOf(body, submessage.flags, 20).value();
  const rtps::Piece payload{body.bytes.subspan(at + 4), body.bytes[at + 1] % 2 == 1};
  if (writer == rtps::kParticipantWriter && (reader == rtps::kParticipantReader || reader == 0))
    return hasSoundTokens(payload) && isAsBefore(source, payload.bytes);
  if (writer != rtps::kHandshakeWriter || (reader != rtps::kHandshakeReader && reader != 0))
    return false;
  if (!isHandshake(payload)) return false;
  if (on_certificate_) {
    const auto shown = shownCertificate(payload.bytes, payload.little);
    if (!shown) return false;
    if (!shown->empty() && !on_certificate_(beginOf(source), *shown)) return false;
  }
  return true;
}

std::optional<std::vector<std::uint8_t>> DatagramFilter::wholeHandshake(
    const Prefix& source, const Submessage& fragment) {
  const rtps::Piece body = fragment.body();
  if (!isDataFragment(body, fragment.flags) || body.entity(8) != rtps::kHandshakeWriter)
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
  const std::uint8_t little = fragment.flags & rtps::kLittleEndian;
  const auto low = static_cast<std::uint8_t>(length);
  const auto high = static_cast<std::uint8_t>(length >> 8U);
  std::vector<std::uint8_t> made{rtps::kData,
                                 static_cast<std::uint8_t>(little | rtps::kHasData)};
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
  if (reader_ != Reader::kFastDds || submessage.kind != rtps::kData) return true;
  if ((submessage.body().entity(8) & rtps::kBuiltin) == rtps::kBuiltin) return true;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  if (shares_.size() >= kMostParticipants && shares_.count(source) == 0) shares_.clear();
  Share& own = shares_[source];
  if (own.take(kSamplesPerSecond, kSamplesAtOnce, now) ||
      shared_.take(kSharedPerSecond, kSharedAtOnce, now))
    return true;
  own.was_exceeded = true;
  return false;
}

std::vector<DatagramFilter::Prefix> DatagramFilter::takeOverShare() {
  std::vector<Prefix> whose;
  const std::lock_guard lock(mutex_);
  for (auto& [source, share] : shares_) {
    if (std::exchange(share.was_exceeded, false)) whose.push_back(source);
  }
  return whose;
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
  const rtps::Piece body = submessage.body();
  switch (submessage.kind) {
    case rtps::kHeartbeat:
    case rtps::kHeartbeatFragment:
    case rtps::kGap: {
      const std::uint32_t writer = body.entity(4);
      return writer == rtps::kTypeRequestWriter || writer == rtps::kTypeReplyWriter;
    }
    case rtps::kData: {
      const std::uint32_t writer = body.entity(8);
      return writer == rtps::kTypeRequestWriter || writer == rtps::kTypeReplyWriter;
    }
    case rtps::kDataFragment:
      return (body.entity(8) & rtps::kBuiltin) == rtps::kBuiltin;
    default:
      return false;
  }
}

std::optional<std::size_t> DatagramFilter::secured(const Prefix& source,
                                                   const Submessage& submessage,
                                                   rtps::Bytes rest) {
  const std::size_t own = submessage.whole.size();
  switch (submessage.kind) {
    case rtps::kInfoTimestamp:
    case rtps::kInfoSource:
    case rtps::kInfoDestination:
      if (!isSound(source, submessage)) return std::nullopt;
      return own;
    case rtps::kData:
      return isHandshakeOrAnnouncement(source, submessage) ? own : 0;
    case rtps::kSecurePrefix: {
      std::size_t length = own;
      for (const std::uint8_t kind : {rtps::kSecureBody, rtps::kSecurePostfix}) {
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

std::optional<DatagramFilter::Submessage> DatagramFilter::submessageAt(rtps::Bytes rest) {
  if (rest.size() < rtps::kSubmessageHeader) return std::nullopt;
  const std::uint8_t kind = rest[0];
  const std::uint8_t flags = rest[1];
  std::size_t length = rtps::Piece{rest, (flags & rtps::kLittleEndian) != 0}.u16(2);
  // 9.4.5.1.3: the last one may leave its length out, where it may not be empty.
  if (length == 0 && kind != rtps::kPad && kind != rtps::kInfoTimestamp)
    length = rest.size() - rtps::kSubmessageHeader;
  if (length > rest.size() - rtps::kSubmessageHeader) return std::nullopt;
  return Submessage{kind, flags, rest.first(rtps::kSubmessageHeader + length)};
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
  const rtps::Piece body = submessage.body();
  switch (submessage.kind) {
    case rtps::kAckNack: {
      const auto set = rtps::setLength(body, 8, 8);
      return set && body.fits(8, *set + 4) && body.sequence(8) >= 0;
    }
    case rtps::kNackFragment: {
      const auto set = rtps::setLength(body, 16, 4);
      return set && body.fits(16, *set + 4) && body.sequence(8) >= 1;
    }
    case rtps::kHeartbeat:
      return body.fits(0, 28) &&
             follows(source, body.entity(4), std::max<std::int64_t>(1, body.sequence(8)),
                     body.sequence(16));
    case rtps::kHeartbeatFragment:
      return body.fits(0, 24) && body.u32(16) <= kLargestSample &&
             follows(source, body.entity(4), body.sequence(8), body.sequence(8));
    case rtps::kGap: {
      const auto set = rtps::setLength(body, 16, 8);
      return set && follows(source, body.entity(4), body.sequence(8), body.sequence(16));
    }
    case rtps::kInfoTimestamp:
      return (submessage.flags & 0x02) != 0 || body.fits(0, 8);
    case rtps::kInfoSource:  // unused, version, vendor, prefix
      return body.bytes.size() == 20 && body.bytes[4] == 2;
    case rtps::kInfoDestination:
      return body.fits(0, 12);
    case rtps::kData:
      return isData(body, submessage.flags, source) &&
             follows(source, body.entity(8), body.sequence(12), body.sequence(12));
    case rtps::kDataFragment:
      return isDataFragment(body, submessage.flags) &&
             follows(source, body.entity(8), body.sequence(12), body.sequence(12));
    default:
      return true;
  }
}

DatagramFilter::Passage DatagramFilter::passSecuredFragment(const Prefix& source,
                                                            const Submessage& fragment,
                                                            std::vector<std::uint8_t>& kept) {
  const std::size_t length = fragment.whole.size();
  const auto whole = wholeHandshake(source, fragment);
  const auto handshake = whole ? submessageAt(*whole) : std::nullopt;
  if (!handshake || !isHandshakeOrAnnouncement(source, *handshake)) return {length, false};
  kept.insert(kept.end(), whole->begin(), whole->end());
  return {length, true};
}

std::optional<DatagramFilter::Passage> DatagramFilter::passSecured(
    const Prefix& source,
    const Submessage& submessage,
    rtps::Bytes rest,
    std::vector<std::uint8_t>& kept) {
  const std::uint8_t kind = submessage.kind;
  if (kind == rtps::kDataFragment) return passSecuredFragment(source, submessage, kept);
  const auto length = secured(source, submessage, rest);
  if (!length) return std::nullopt;
  if (*length == 0) return Passage{submessage.whole.size(), false};
  const std::size_t at = kept.size();
  // What belongs to it follows it in the datagram.
  kept.insert(kept.end(), submessage.whole.begin(), submessage.whole.end());
  const std::size_t belonging = *length - submessage.whole.size();
  kept.insert(kept.end(), rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(belonging));
  if (kind == rtps::kData && reader_ == Reader::kCyclone)
    rtps::blankTypes(std::span(kept).subspan(at));
  return Passage{*length, kind == rtps::kData || kind == rtps::kSecurePrefix};
}

std::optional<DatagramFilter::Passage> DatagramFilter::passOpen(
    const Prefix& source, const Submessage& submessage, std::vector<std::uint8_t>& kept) {
  const std::uint8_t kind = submessage.kind;
  const rtps::Bytes whole = submessage.whole;
  if (!rtps::isPassed(kind)) return Passage{whole.size(), false};
  if (!isSound(source, submessage)) return std::nullopt;
  if (isKeptFrom(submessage) || !isWithinShare(source, submessage))
    return Passage{whole.size(), false};
  const std::size_t at = kept.size();
  kept.insert(kept.end(), whole.begin(), whole.end());
  const auto added = std::span(kept).subspan(at);
  if (kind == rtps::kAckNack && reader_ == Reader::kFastDds) rtps::beginAnew(added);
  if (kind == rtps::kData && reader_ == Reader::kCyclone) rtps::blankTypes(added);
  return Passage{whole.size(), true};
}

std::optional<DatagramFilter::Passage> DatagramFilter::passOne(
    const Prefix& source,
    const Submessage& submessage,
    rtps::Bytes rest,
    std::vector<std::uint8_t>& kept) {
  if (submessage.kind == rtps::kData && passes_over_clients_ &&
      announcesAClient(submessage.body(), submessage.flags))
    return Passage{submessage.whole.size(), false};
  return domain_ == Domain::kSecured ? passSecured(source, submessage, rest, kept)
                                     : passOpen(source, submessage, kept);
}

std::span<const std::uint8_t> DatagramFilter::pass(rtps::Bytes datagram,
                                                   std::vector<std::uint8_t>& kept) {
  constexpr std::array<std::uint8_t, 5> kProtocol{'R', 'T', 'P', 'S', 2};
  if (datagram.size() < rtps::kMessageHeader + rtps::kSubmessageHeader ||
      !std::equal(kProtocol.begin(), kProtocol.end(), datagram.begin()))
    return {};
  Prefix source;
  std::copy_n(datagram.begin() + 8, source.size(), source.begin());
  if (isRefused(source)) return {};

  kept.assign(datagram.begin(), datagram.begin() + rtps::kMessageHeader);
  bool has_content = false;  // beyond what says of whom and for whom the rest is
  for (rtps::Bytes rest = datagram.subspan(rtps::kMessageHeader); !rest.empty();) {
    const auto submessage = submessageAt(rest);
    if (!submessage) return {};
    const rtps::Bytes whole = submessage->whole;
    const auto passage = passOne(source, *submessage, rest.subspan(whole.size()), kept);
    if (!passage) return {};
    has_content = has_content || passage->has_content;
    // Cyclone DDS packs what several participants of a process say: the rest is another's.
    if (submessage->kind == rtps::kInfoSource && whole.size() >= source.size()) {
      std::copy_n(whole.end() - std::ssize(source), source.size(), source.begin());
      if (isRefused(source)) return {};
    }
    rest = rest.subspan(passage->length);
  }
  if (!has_content) return {};
  return kept;
}

}  // namespace handgraft::idl
