#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "hardware/bridge/motion_state.h"
#include "hardware/bridge/ros_node.h"
#include "hardware/bridge/telemetry.h"
#include "hardware/bridge/wake_event.h"
#include "idl/cyclone/participant.h"

namespace handgraft::bridge {

/// What a bridge publishes: joint states once a period, its status at each change and ten times
/// a second, and both for ROS 2, with diagnostics once a second.
class Publisher {
 public:
  using Clock = std::chrono::steady_clock;

  /// `bell` rings when ROS asks for something. Errors: InvalidInput for a bad namespace;
  /// TransportError.
  Publisher(const idl::cyclone::Participant& participant,
            const std::string& ros_namespace,
            std::uint32_t bridge_id,
            RosNode::Obey obey,
            const std::shared_ptr<WakeEvent>& bell);

  /// Whether `publish` would tell this status now.
  [[nodiscard]] bool isDue(const v1::BridgeStatus& status, Clock::time_point now) const;

  /// `news`: the state of a period that nobody was told of; null: none. That there is no hand
  /// yet is told with the status. Errors: TransportError.
  void publish(const BridgeIdentity& identity,
               const MotionState& state,
               const MotionState* news,
               const v1::BridgeStatus& status,
               Clock::time_point now);

 private:
  idl::cyclone::Writer<v1::JointState> joint_states_;
  idl::cyclone::Writer<v1::BridgeStatus> statuses_;
  RosNode ros_;
  v1::BridgeStatus last_status_;
  Clock::time_point status_due_{};
  Clock::time_point diagnosis_due_{};
  std::uint64_t sequence_number_ = 0;
};

/// The system's time at a moment of the steady clock.
std::chrono::nanoseconds systemTimeOf(Publisher::Clock::time_point moment);

}  // namespace handgraft::bridge
