#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "idl/cyclone/participant.h"
#include "idl/hardware.h"

namespace handgraft::bridge {

/// Whether another bridge lives under our number: a command would be obeyed by both, and who
/// asks for a status would see one of them.
///
/// Our own statuses come back as well; they are known by their stamps. One status is none: it
/// may be the last word of a bridge that has just ended.
class DuplicateBridgeMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::milliseconds kPatience{2000};  // twenty statuses missed

  explicit DuplicateBridgeMonitor(std::uint32_t bridge_id) : bridge_id_(bridge_id) {}

  /// To be told before a status of ours with this stamp is written.
  void noteOwn(std::int64_t stamp_ns);

  void see(const v1::BridgeStatus& status, Time now);

  /// The other one, for people ("dynamixel /dev/ttyUSB0, hand 'leap'"), while it was heard
  /// twice and the last time not longer than `patience` ago.
  [[nodiscard]] std::optional<std::string> rival(
      Time now, std::chrono::milliseconds patience = kPatience) const;

 private:
  std::uint32_t bridge_id_;
  std::array<std::int64_t, 64> own_{};  // stamps; statuses come back in less
  std::size_t own_count_ = 0;
  std::optional<Time> last_heard_;
  std::int64_t last_stamp_ns_ = 0;
  bool is_repeated_ = false;
  std::string rival_;
};

/// What to do about it, once both run.
std::string rivalAdvice(std::uint32_t bridge_id, const std::string& rival);

/// Listens for 1.5 s, or until `stop`, for a bridge with this number. To be asked before the
/// own one speaks.
///
/// Errors: TransportError, which names the other one and how to give another number.
void requireNoRival(const idl::cyclone::Participant& participant,
                    std::uint32_t bridge_id,
                    const std::atomic<bool>& stop);

}  // namespace handgraft::bridge
