#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hardware/bridge/bridge_logic.h"
#include "hardware/bridge/hand_driver.h"
#include "idl/cyclone/participant.h"

namespace handgraft::bridge {

/// One thing that the bridge has to say, and how it stands just then.
struct BridgeReport {
  std::string message;
  v1::BridgeState state = v1::BRIDGE_DISCONNECTED;
  std::uint64_t session_id = 0;
  std::string hand;  ///< empty: none yet
  std::vector<std::string> names;
  std::vector<double> position;  ///< measured, rad or m
  std::vector<double> target;    ///< empty: none yet
};

/// The bridge on DDS: feeds a BridgeLogic with what arrives, a HandDriver with what comes out,
/// once a period by absolute deadlines, and publishes what the hand measures. A period that
/// comes late is not made up for: the hand is then slower, never faster.
class Bridge {
 public:
  /// Makes the driver of a hand; may throw DeviceError or InvalidInput, which latches a fault.
  using MakeDriver = std::function<std::unique_ptr<HandDriver>(const HandPlan&)>;
  using Report = std::function<void(const BridgeReport&)>;

  /// Errors: InvalidInput for a period that is not in (0, 1] s; TransportError.
  Bridge(const idl::cyclone::Participant& participant,
         const BridgeOptions& options,
         MakeDriver make_driver,
         Report report);
  ~Bridge();

  /// Serves until `stop`, then brakes, switches the motors off and returns.
  void run(const std::atomic<bool>& stop);

  /// Periods whose deadline had passed before their work began.
  [[nodiscard]] unsigned long missedPeriods() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::bridge
