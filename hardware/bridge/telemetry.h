#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "hardware/bridge/motion_state.h"
#include "hardware/config/hand_config.h"
#include "idl/hardware.h"
#include "idl/sensor_msgs.h"

namespace handgraft::bridge {

/// What the bridge says of itself beside the hand's state.
struct BridgeIdentity {
  std::uint32_t bridge_id = 1;
  std::string device;  ///< "simulated", "dynamixel /dev/ttyUSB0", ...
  std::string hand;    ///< empty: none yet
  std::string config;  ///< the file's name; empty: none
  std::vector<std::string> motors;
  std::vector<std::string> joints;   ///< empty: no hand yet
  std::vector<std::string> sliding;  ///< of them
  std::uint64_t session_id = 0;
  double period_s = 0.01;
};

v1::BridgeState wireState(safety::GovernorState state);

/// The latched fault as it is told on the wire.
v1::BridgeFault wireFault(const MotionState& state);

/// `system_ns` is the system's time when `state` was measured. An empty `names`: no hand yet.
v1::JointState jointState(const BridgeIdentity& identity,
                          const std::vector<std::string>& names,
                          const MotionState& state,
                          std::uint64_t sequence_number,
                          std::chrono::nanoseconds system_ns);

/// Measured joints for ROS 2: joints whose velocity is not known leave all velocities out, and
/// efforts are left out where none is known.
sensor_msgs::msg::dds_::JointState_ rosJointState(const std::string& frame,
                                                  const std::vector<std::string>& names,
                                                  const MotionState& state,
                                                  std::chrono::nanoseconds system_ns);

v1::BridgeStatus bridgeStatus(const BridgeIdentity& identity,
                              const MotionState& state,
                              std::chrono::nanoseconds system_ns);

}  // namespace handgraft::bridge
