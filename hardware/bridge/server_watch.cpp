#include "hardware/bridge/server_watch.h"

#include <algorithm>

namespace handgraft::bridge {

void ServerWatch::see(const v1::ServerStatus& status, Time now) {
  std::erase_if(last_heard_, [now](const auto& entry) {
    return now - entry.second > kPatience;
  });
  if (status.stopping()) {
    last_heard_.erase(status.server_id());
  } else {
    last_heard_[status.server_id()] = now;
  }
}

bool ServerWatch::isThere(Time now) const {
  return std::any_of(last_heard_.begin(), last_heard_.end(), [now](const auto& entry) {
    return now - entry.second <= kPatience;
  });
}

}  // namespace handgraft::bridge
