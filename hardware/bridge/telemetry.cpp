#include "hardware/bridge/telemetry.h"

#include <algorithm>
#include <cmath>

namespace handgraft::bridge {

namespace {

using devices::Fault;
using safety::FaultCause;
using safety::GovernorState;

v1::BridgeFault wireFault(Fault::Kind kind) {
  switch (kind) {
    case Fault::Kind::kNone:
      return v1::FAULT_NONE;
    case Fault::Kind::kWire:
      return v1::FAULT_WIRE;
    case Fault::Kind::kSilent:
      return v1::FAULT_SILENT;
    case Fault::Kind::kHardware:
      return v1::FAULT_HARDWARE;
    case Fault::Kind::kHot:
      return v1::FAULT_HOT;
    case Fault::Kind::kWatchdog:
      return v1::FAULT_WATCHDOG;
    case Fault::Kind::kPowerLost:
      return v1::FAULT_POWER_LOST;
    case Fault::Kind::kStarved:
      return v1::FAULT_STARVED;
    case Fault::Kind::kBadTarget:
      return v1::FAULT_BAD_TARGET;
    case Fault::Kind::kNoWatchdog:
      return v1::FAULT_NO_WATCHDOG;
  }
  return v1::FAULT_HARDWARE;
}

/// Of a device that is gone or silent nobody knows.
v1::MotorPower powerOf(const BridgeIdentity& identity, const MotionState& state) {
  if (state.is_powered) return v1::POWER_ON;
  // A bridge without a hand has no motors yet.
  const bool is_away = state.state == GovernorState::kDisconnected && !identity.hand.empty();
  const v1::BridgeFault fault = wireFault(state);
  return is_away || fault == v1::FAULT_WIRE || fault == v1::FAULT_SILENT ? v1::POWER_UNKNOWN
                                                                         : v1::POWER_OFF;
}

double secondsOf(devices::Duration time) {
  return std::chrono::duration<double>(time).count();
}

double secondsOf(const std::optional<devices::Duration>& time) {
  return time ? secondsOf(*time) : -1.0;
}

}  // namespace

v1::BridgeState wireState(GovernorState state) {
  switch (state) {
    case GovernorState::kDisconnected:
      return v1::BRIDGE_DISCONNECTED;
    case GovernorState::kIdle:
      return v1::BRIDGE_IDLE;
    case GovernorState::kArmed:
      return v1::BRIDGE_ARMED;
    case GovernorState::kHolding:
      return v1::BRIDGE_HOLDING;
    case GovernorState::kFault:
      return v1::BRIDGE_FAULT;
    case GovernorState::kEStop:
      return v1::BRIDGE_ESTOP;
  }
  return v1::BRIDGE_FAULT;
}

v1::BridgeFault wireFault(const MotionState& state) {
  switch (state.fault) {
    case FaultCause::kNone:
    case FaultCause::kCount:
      return v1::FAULT_NONE;
    case FaultCause::kDevice:
      return state.guard_failed ? v1::FAULT_GUARD : wireFault(state.device_fault.kind);
    case FaultCause::kDeviceLost:
      return v1::FAULT_WIRE;
    case FaultCause::kDeviceSilent:
      return v1::FAULT_SILENT;
    case FaultCause::kBadMeasurement:
    case FaultCause::kOutOfRange:
    case FaultCause::kMotorsOutside:
      return v1::FAULT_MEASUREMENT;
    case FaultCause::kNoPower:
    case FaultCause::kPowerLost:
      // What cut the power shows with the device, if the device knows.
      return state.device_fault ? wireFault(state.device_fault.kind) : v1::FAULT_POWER_LOST;
    case FaultCause::kStaysOn:
      return v1::FAULT_HARDWARE;
    case FaultCause::kOverruns:
    case FaultCause::kGap:
      return v1::FAULT_LATE;
    case FaultCause::kOutput:
      return v1::FAULT_GUARD;
  }
  return v1::FAULT_HARDWARE;
}

v1::JointState jointState(const BridgeIdentity& identity,
                          const std::vector<std::string>& names,
                          const MotionState& state,
                          std::uint64_t sequence_number,
                          std::chrono::nanoseconds system_ns) {
  v1::JointState message;
  message.bridge_id(identity.bridge_id);
  message.sequence_number(sequence_number);
  message.state(wireState(state.state));
  message.message(describe(state));
  message.session_id(identity.session_id);
  message.stamp_ns(system_ns.count());
  if (names.empty() || !state.is_connected) return message;
  message.names(names);
  message.sliding(identity.sliding);
  message.position(state.position);
  message.velocity(state.velocity);
  message.effort(state.effort);
  message.motors(identity.motors);
  message.current_A(state.motor_current);
  message.temperature_c(state.motor_temperature);
  message.touch_N(state.touch);
  if (state.stream != 0) message.target(state.target);
  if (state.is_powered) {
    message.command(state.command);
    message.residual(state.residual);
  }
  return message;
}

sensor_msgs::msg::dds_::JointState_ rosJointState(const std::string& frame,
                                                  const std::vector<std::string>& names,
                                                  const MotionState& state,
                                                  std::chrono::nanoseconds system_ns) {
  // Rounded down, also before 1970: nanoseconds are never negative.
  const auto seconds = std::chrono::floor<std::chrono::seconds>(system_ns);
  sensor_msgs::msg::dds_::JointState_ message;
  message.header().stamp().sec(static_cast<std::int32_t>(seconds.count()));
  message.header().frame_id(frame);
  message.header().stamp().nanosec(static_cast<std::uint32_t>((system_ns - seconds).count()));
  message.name(names);
  message.position(state.position);
  const bool is_known = std::all_of(state.velocity.begin(), state.velocity.end(), [](double v) {
    return std::isfinite(v);
  });
  if (is_known) message.velocity(state.velocity);
  const bool has_efforts =
      std::any_of(state.effort.begin(), state.effort.end(), [](double told) {
        return std::isfinite(told);
      });
  if (has_efforts) message.effort(state.effort);
  return message;
}

v1::BridgeStatus bridgeStatus(const BridgeIdentity& identity,
                              const MotionState& state,
                              std::chrono::nanoseconds system_ns) {
  v1::BridgeStatus message;
  message.bridge_id(identity.bridge_id);
  message.device(identity.device);
  message.hand(identity.hand);
  message.config(identity.config);
  message.state(wireState(state.state));
  message.fault(wireFault(state));
  message.reason(describe(state));
  message.power(powerOf(identity, state));
  message.homing(state.is_homing);
  message.homed(state.is_homed);
  message.slow(state.is_slow || !state.slower.view().empty());
  message.session_id(identity.session_id);
  message.command_age_s(secondsOf(state.command_age));
  message.stream_age_s(secondsOf(state.stream_age));
  message.period_s(identity.period_s);
  message.periods(state.periods);
  message.overruns(state.overruns);
  message.worst_lateness_s(secondsOf(state.worst_lateness));
  message.realtime(state.is_realtime);
  message.poses_accepted(state.poses_accepted);
  message.poses_refused(state.poses_refused);
  message.last_refusal(std::string(state.last_refusal.view()));
  message.refusal(state.refusal);
  message.refusal_count(state.refusals);
  message.clamping(std::string(state.clamping.view()));
  message.clamped_rad(state.clamped_rad);
  message.clamped(state.clamped);
  message.limited(state.limited);
  message.answers_lost(state.counters.missed + state.counters.damaged);
  message.bytes_discarded(state.counters.garbage_bytes);
  message.tracking_rad(state.tracking_rad);
  message.residual_rad(state.residual_rad);
  message.temperature_c(state.temperature_c);
  message.stamp_ns(system_ns.count());
  return message;
}

}  // namespace handgraft::bridge
