#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hardware/bridge/motion_state.h"
#include "hardware/bridge/telemetry.h"
#include "hardware/bridge/wake_event.h"
#include "idl/cyclone/participant.h"
#include "idl/hardware.h"
#include "idl/ros2.h"

namespace handgraft::bridge {

/// Errors: InvalidInput for what is no ROS 2 namespace. Without slashes at its ends.
std::string rosNamespace(const std::string& told);

/// One point, to be reached within a period: what the governor lets the hand do now.
/// `before`: the command before; empty: it began just now.
trajectory_msgs::msg::dds_::JointTrajectory_ rosTrajectory(
    const std::vector<std::string>& names,
    const std::vector<double>& command,
    const std::vector<double>& before,
    double period_s);

/// What the status tells, as a driver's diagnostics.
diagnostic_msgs::msg::dds_::DiagnosticArray_ rosDiagnostics(const std::string& node,
                                                            const v1::BridgeStatus& status,
                                                            std::chrono::nanoseconds system_ns);

/// Whether a command is done, by the status after it.
bool isDone(v1::HandCommandKind kind, const v1::BridgeStatus& status);

/// What ROS 2 nodes see of the bridge: measured joints, the governed motion as a trajectory,
/// diagnostics, and a Trigger service for each command.
///
/// Services as rmw_cyclonedds carries them. A service answers once the command is done or
/// refused, with the reason as its message; homing answers when it has ended, all others within
/// 10 s.
class RosNode {
 public:
  using Obey = std::function<void(v1::HandCommandKind)>;

  /// `bridge_id` other than 1 is part of the node's name: handgraft_bridge_2.
  /// `bell` rings when a service is asked for. Errors: InvalidInput for a bad namespace;
  /// TransportError.
  RosNode(const idl::cyclone::Participant& participant,
          const std::string& ros_namespace,
          std::uint32_t bridge_id,
          Obey obey,
          const std::shared_ptr<WakeEvent>& bell);
  ~RosNode();

  /// Takes requests and obeys them, and answers those that are settled by `status`.
  void serve(const v1::BridgeStatus& status, std::chrono::steady_clock::time_point now);

  /// Once a period.
  void publish(const BridgeIdentity& identity,
               const std::vector<std::string>& names,
               const MotionState& state,
               std::chrono::nanoseconds system_ns);

  /// Once a second, and at each change.
  void publish(const v1::BridgeStatus& status, std::chrono::nanoseconds system_ns);

  [[nodiscard]] const std::string& name() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::bridge
