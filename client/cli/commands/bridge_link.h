#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "client/present/interruption.h"
#include "core/base/network.h"
#include "idl/cyclone/participant.h"
#include "idl/hardware.h"

namespace handgraft::client {

/// The bridges on this domain, by what they say of themselves.
///
/// Errors of every call: TransportError without a bridge; Cancelled once the user asked to
/// stop.
class BridgeLink {
 public:
  BridgeLink(const Network& network, Interruption& interruption);

  /// Those that speak within 2 s, or 0.3 s after the first of them.
  std::vector<v1::BridgeStatus> all();

  /// The bridge asked for; without a number the only one. Errors: InvalidInput where there are
  /// several, or not that one.
  v1::BridgeStatus one(const std::optional<std::uint32_t>& bridge_id);

  /// Publishes a command until `is_done` says so of the newest status: that status. Repeats are
  /// obeyed once. Errors: TransportError for a bridge that is heard no more, that is not seen
  /// to listen within 3 s, or that does not answer for `patience`.
  v1::BridgeStatus command(std::uint32_t bridge_id,
                           v1::HandCommandKind kind,
                           std::chrono::seconds patience,
                           const std::function<bool(const v1::BridgeStatus&)>& is_done);

  /// An emergency stop of the bridge asked for, else of all: each is told the moment it is
  /// heard of, and again until `is_done` says so of its status, or for `patience`. Their newest
  /// statuses. Errors: as `one`, but all are stopped where no number is given.
  std::vector<v1::BridgeStatus> stop(
      const std::optional<std::uint32_t>& bridge_id,
      std::chrono::seconds patience,
      const std::function<bool(const v1::BridgeStatus&)>& is_done);

  /// The newest status of a bridge after waiting a moment for news.
  v1::BridgeStatus news(std::uint32_t bridge_id);

  [[nodiscard]] const idl::cyclone::Participant& participant() const { return participant_; }

 private:
  using Clock = std::chrono::steady_clock;

  void take();
  void requireAlive(std::uint32_t bridge_id, Clock::time_point since);
  [[nodiscard]] v1::HandCommand make(std::uint32_t bridge_id, v1::HandCommandKind kind) const;
  [[nodiscard]] std::vector<v1::BridgeStatus> known() const;
  [[nodiscard]] std::chrono::milliseconds repeat();

  Network network_;
  Interruption& interruption_;
  idl::cyclone::Participant participant_;
  idl::cyclone::Reader<v1::BridgeStatus> statuses_;
  idl::cyclone::Lazy<idl::cyclone::Writer<v1::HandCommand>> commands_;  ///< operators' alone
  std::map<std::uint32_t, v1::BridgeStatus> bridges_;
  std::map<std::uint32_t, Clock::time_point> heard_;
};

}  // namespace handgraft::client
