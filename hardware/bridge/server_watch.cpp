#include "hardware/bridge/server_watch.h"

#include <algorithm>

namespace handgraft::bridge {

namespace {

std::int64_t nanosecondsOf(ServerWatch::Time time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

}  // namespace

void ServerWatch::see(const v1::ServerStatus& status, Time now, std::int64_t written_ns) {
  if (written_ns != 0) clock_offset_ns_ = written_ns - nanosecondsOf(now);
  std::erase_if(last_heard_, [now](const auto& entry) {
    return now - entry.second > kPatience;
  });
  if (status.stopping()) {
    last_heard_.erase(status.server_id());
  } else {
    last_heard_[status.server_id()] = now;
  }
}

std::optional<std::int64_t> ServerWatch::serverTime(Time now) const {
  if (!clock_offset_ns_) return std::nullopt;
  return nanosecondsOf(now) + *clock_offset_ns_;
}

bool ServerWatch::isThere(Time now) const {
  return std::any_of(last_heard_.begin(), last_heard_.end(), [now](const auto& entry) {
    return now - entry.second <= kPatience;
  });
}

}  // namespace handgraft::bridge
