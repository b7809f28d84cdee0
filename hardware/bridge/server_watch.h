#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>

#include "idl/service.h"

namespace handgraft::bridge {

/// Whether any server lives on this domain, told by the status that each sends once a second.
class ServerWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::milliseconds kPatience{3000};  // three statuses missed

  /// `written_ns`: by the server's clock; 0 if it is not known.
  void see(const v1::ServerStatus& status, Time now, std::int64_t written_ns = 0);

  /// True while some server was heard within the last 3 s and has not said that it stops.
  [[nodiscard]] bool isThere(Time now) const;

  /// The clock of the server heard last, a little behind: by what its status was on its way.
  [[nodiscard]] std::optional<std::int64_t> serverTime(Time now) const;

 private:
  std::map<std::uint64_t, Time> last_heard_;
  std::optional<std::int64_t> clock_offset_ns_;  ///< the server's clock minus ours
};

}  // namespace handgraft::bridge
