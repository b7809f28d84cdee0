#pragma once

#include <chrono>
#include <cstdint>
#include <map>

#include "idl/service.h"

namespace handgraft::bridge {

/// Whether any server lives on this domain, told by the status that each sends once a second.
class ServerWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::milliseconds kPatience{3000};  // three statuses missed

  void see(const v1::ServerStatus& status, Time now);

  /// True while some server was heard within the last 3 s and has not said that it stops.
  [[nodiscard]] bool isThere(Time now) const;

 private:
  std::map<std::uint64_t, Time> last_heard_;
};

}  // namespace handgraft::bridge
