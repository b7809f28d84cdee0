#include "hardware/bridge/motion_state.h"

#include <cmath>

#include <fmt/format.h>

namespace handgraft::bridge {

namespace {

using safety::FaultCause;
using safety::GovernorState;
using safety::HoldCause;

const char* textOf(HoldCause cause) {
  switch (cause) {
    case HoldCause::kNone:
      return "";
    case HoldCause::kDisarmed:
      return "braking; then the motors go off";
    case HoldCause::kStale:
      return "the stream is stale; ARM moves on";
    case HoldCause::kStreamChanged:
      return "another session took over; ARM moves on";
    case HoldCause::kMotorLimited:
      return "a motor is held back, hot or blocked; ARM moves on";
  }
  return "";
}

std::string faultText(const MotionState& state) {
  if (!state.fault_text.view().empty()) return std::string(state.fault_text.view());
  if (state.guard_failed) return "what was to leave for the motors broke a limit";
  if (state.fault == FaultCause::kDevice) return devices::describe(state.device_fault);
  return toString(state.fault);
}

std::string latchedText(const MotionState& state) {
  std::string text;
  if (state.state == GovernorState::kEStop) {
    text = state.stop_mode == safety::StopMode::kCut ? "emergency stop, cut" : "emergency stop";
    if (state.fault != FaultCause::kNone) text += ", then " + faultText(state);
  } else {
    text = faultText(state);
  }
  if (!state.trouble.view().empty()) text += fmt::format(" ({})", state.trouble.view());
  return text + "; RESET, then ARM, to move again";
}

}  // namespace

std::string describe(const MotionState& state) {
  switch (state.state) {
    case GovernorState::kDisconnected:
      return state.trouble.view().empty() ? "no device yet" : std::string(state.trouble.view());
    case GovernorState::kIdle:
      if (state.is_homing) return "homing";
      if (!state.trouble.view().empty()) return std::string(state.trouble.view());
      if (state.is_homed) return "motors off";
      return fmt::format("motors off; {}zeros are not known{}{}",
                         state.needs_homing ? "HOME first: " : "",
                         state.zeros.view().empty() ? "" : ": ", state.zeros.view());
    case GovernorState::kArmed:
      if (state.is_slow) return "armed, slowly to a far pose";
      if (!state.slower.view().empty())
        return fmt::format("armed, slower than its samples ask for: joint '{}' is not as fast",
                           state.slower.view());
      return "armed";
    case GovernorState::kHolding:
      if (state.hold == HoldCause::kMotorLimited && !state.held.view().empty())
        return fmt::format("{}; ARM moves on", state.held.view());
      return textOf(state.hold);
    case GovernorState::kFault:
    case GovernorState::kEStop:
      return latchedText(state);
  }
  return "unknown";
}

}  // namespace handgraft::bridge
