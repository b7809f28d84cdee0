#include "server/transport/heartbeat_throttle.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "idl/datagrams/rtps.h"

namespace handgraft::server {

namespace wire = idl::rtps;

namespace {

/// RTPS 2.x, 8.3.3.1.2.
constexpr std::size_t kSourceAt = 8;
/// What Fast DDS adds to what it sends, and nobody reads (statistics).
constexpr std::uint8_t kVendorsOwn = 0x80;

struct Question {
  std::optional<HeartbeatThrottle::Prefix> whom;  ///< nothing: all
  std::uint32_t writer = 0;
  std::int64_t newest = 0;  ///< sample that it has
};

/// Of a datagram of Fast DDS: HEARTBEAT, perhaps behind INFO_DST, and nothing that anybody
/// needs.
std::optional<Question> questionOf(wire::Bytes datagram) {
  if (datagram.size() < wire::kMessageHeader) return std::nullopt;
  Question question;
  bool asks = false;
  for (wire::Bytes rest = datagram.subspan(wire::kMessageHeader);
       rest.size() >= wire::kSubmessageHeader;) {
    const std::uint8_t kind = rest[0];
    const wire::Piece piece{rest, (rest[1] & wire::kLittleEndian) != 0};
    // The last one's length may be left out.
    const std::size_t told = piece.u16(2);
    const std::size_t length =
        told == 0 ? rest.size() - wire::kSubmessageHeader : std::size_t{told};
    const wire::Piece body = piece.from(wire::kSubmessageHeader);
    if (!body.fits(0, length)) return std::nullopt;
    if (kind == wire::kInfoDestination && length >= sizeof(HeartbeatThrottle::Prefix) &&
        !question.whom && !asks) {
      question.whom.emplace();
      std::copy_n(body.bytes.begin(), question.whom->size(), question.whom->begin());
    } else if (kind == wire::kHeartbeat && length >= 24 && !asks) {
      question.writer = body.entity(4);
      question.newest = body.sequence(16);
      asks = true;
    } else if (kind < kVendorsOwn) {
      return std::nullopt;
    }
    rest = rest.subspan(wire::kSubmessageHeader + length);
  }
  if (!asks) return std::nullopt;
  return question;
}

}  // namespace

void HeartbeatThrottle::hear(std::span<const std::uint8_t> datagram, Clock::time_point now) {
  Prefix source;
  if (datagram.size() < kSourceAt + source.size()) return;
  std::copy_n(datagram.begin() + kSourceAt, source.size(), source.begin());
  const std::lock_guard lock(mutex_);
  tidy(now);
  Peer& peer = peers_.try_emplace(source, Peer{now, now, {}}).first->second;
  peer.heard = now;
  for (auto& [writer, asked] : peer.asked)
    asked.period = kFirstPeriod;
}

bool HeartbeatThrottle::maySend(std::span<const std::uint8_t> datagram, Clock::time_point now) {
  const auto question = questionOf(datagram);
  if (!question) return true;
  const std::lock_guard lock(mutex_);
  const Clock::duration turn = lively_ * kPeriodOfFew / kFew;
  if (!question->whom) {
    Announced& announced = announced_[question->writer];
    const bool is_news = std::exchange(announced.newest, question->newest) != question->newest;
    if (!is_news && lively_ > kFew && now - announced.last < turn) return false;
    announced.last = now;
    return true;
  }
  const auto found = peers_.find(*question->whom);
  if (found == peers_.end()) return true;
  Probe& asked = found->second.asked[question->writer];
  const bool is_silent = now - found->second.heard >= kSilent;
  // Discovery's writers ask once and wait a second for an answer: who has just come would not
  // know of the server until then, nor of what it says, if others' turns came first.
  const bool is_discovery = (question->writer & wire::kBuiltin) == wire::kBuiltin;
  const bool goes_first = is_discovery || now - found->second.met < kNew || lively_ <= kFew;
  const Clock::duration period = is_silent    ? asked.period
                                 : goes_first ? Clock::duration::zero()
                                              : turn;
  if (now - asked.last < period) return false;
  asked.last = now;
  if (is_silent) asked.period = std::min<Clock::duration>(2 * period, kLongestPeriod);
  return true;
}

void HeartbeatThrottle::tidy(Clock::time_point now) {
  constexpr std::chrono::seconds kPeriod(1);
  constexpr std::chrono::seconds kLively(3);  // clients announce themselves every 2 s
  constexpr std::chrono::seconds kForgotten(60);
  constexpr std::size_t kMost = 20'000;
  if (now - tidied_ < kPeriod && peers_.size() < kMost) return;
  tidied_ = now;
  std::erase_if(peers_, [&](const auto& one) {
    return now - one.second.heard > kForgotten;
  });
  // Writers come and go with sessions.
  std::erase_if(announced_, [&](const auto& one) {
    return now - one.second.last > kForgotten;
  });
  if (peers_.size() >= kMost) peers_.clear();
  lively_ = static_cast<std::size_t>(
      std::count_if(peers_.begin(), peers_.end(), [&](const auto& one) {
        return now - one.second.heard < kLively;
      }));
}

}  // namespace handgraft::server
