#include "hardware/bridge/duplicate_bridge_monitor.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kListen(1500);
constexpr milliseconds kLately(700);  // one that ended meanwhile is none
constexpr milliseconds kTick(50);

}  // namespace

void DuplicateBridgeMonitor::noteOwn(std::int64_t stamp_ns) {
  own_[own_count_++ % own_.size()] = stamp_ns;
}

void DuplicateBridgeMonitor::see(const v1::BridgeStatus& status, Time now) {
  if (status.bridge_id() != bridge_id_) return;
  const std::size_t known = std::min(own_count_, own_.size());
  const auto end = own_.begin() + static_cast<std::ptrdiff_t>(known);
  if (std::find(own_.begin(), end, status.stamp_ns()) != end) return;
  const bool goes_on = last_heard_ && now - *last_heard_ <= kPatience;
  is_repeated_ = goes_on && (is_repeated_ || status.stamp_ns() != last_stamp_ns_);
  last_heard_ = now;
  last_stamp_ns_ = status.stamp_ns();
  rival_ = status.device();
  if (!status.hand().empty()) rival_ += ", hand " + quoted(status.hand());
  if (!status.config().empty()) rival_ += ", config " + quoted(status.config());
}

std::optional<std::string> DuplicateBridgeMonitor::rival(Time now,
                                                         milliseconds patience) const {
  if (!is_repeated_ || now - *last_heard_ > patience) return std::nullopt;
  return rival_;
}

std::string rivalAdvice(std::uint32_t bridge_id, const std::string& rival) {
  return fmt::format(
      "another bridge {} is there: {}; end one, or give it another number with --bridge-id",
      bridge_id, rival);
}

void requireNoRival(const idl::cyclone::Participant& participant,
                    std::uint32_t bridge_id,
                    const std::atomic<bool>& stop) {
  idl::cyclone::Reader<v1::BridgeStatus> statuses(participant, idl::kBridgeStatusTopic);
  DuplicateBridgeMonitor watch(bridge_id);
  const Clock::time_point start = Clock::now();
  while (!stop && Clock::now() - start < kListen) {
    statuses.wait(kTick);
    statuses.take([&](const v1::BridgeStatus& status) {
      watch.see(status, Clock::now());
    });
  }
  if (const std::optional<std::string> rival = watch.rival(Clock::now(), kLately)) {
    throw TransportError(
        fmt::format("bridge {} is there already on {}: {}; give this one another number with "
                    "--bridge-id",
                    bridge_id, describe(participant.network()), *rival));
  }
}

}  // namespace handgraft::bridge
