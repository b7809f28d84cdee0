#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bridge/hand_plan.h"
#include "hardware/config/hand_config.h"
#include "idl/cyclone/participant.h"
#include "idl/hardware.h"

namespace handgraft::bridge {

/// What a bridge is told when it starts.
struct BridgeOptions {
  std::uint32_t bridge_id = 1;
  std::optional<std::uint64_t> session;  ///< absent: the one that began to stream last
  bool with_intermediate = false;        ///< also follow poses of solves that still run

  std::optional<config::HandConfig> config;  ///< absent: simulates whatever hand is asked for
  std::string config_name;                   ///< the file's
  std::string ros_namespace;                 ///< of its ROS 2 topics and services

  // === Of the simulated hand alone
  /// Arms by itself for each fresh pose until it is disarmed or its server is gone, and
  /// completes the last pose of a session that is closed.
  bool arms_itself = true;
  double period_s = 0.01;
  MotionBounds bounds;
};

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

/// The bridge on DDS. A thread of its own (MotionThread) moves the hand; this one takes what
/// arrives, hands it over, says that the stream lives, and publishes what there is to tell.
class Bridge {
 public:
  using Report = std::function<void(const BridgeReport&)>;

  /// `estop` has to live as long as this; set at any time, also by a signal handler, it stops
  /// the hand and is cleared.
  /// Errors: InvalidInput for a period that is not in (0, 1] s or a config that governor,
  /// transmission or driver do not accept; TransportError.
  Bridge(const idl::cyclone::Participant& participant,
         const BridgeOptions& options,
         std::atomic<bool>& estop,
         Report report);
  ~Bridge();

  /// Serves until `stop`, then brakes, switches the motors off and returns.
  void run(const std::atomic<bool>& stop);

  /// Periods that began late.
  [[nodiscard]] std::uint64_t overruns() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::bridge
