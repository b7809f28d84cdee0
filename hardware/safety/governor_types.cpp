#include "hardware/safety/governor_types.h"

namespace handgraft::safety {

const char* toString(GovernorState state) {
  switch (state) {
    case GovernorState::kDisconnected:
      return "disconnected";
    case GovernorState::kIdle:
      return "idle";
    case GovernorState::kArmed:
      return "armed";
    case GovernorState::kHolding:
      return "holding";
    case GovernorState::kFault:
      return "fault";
    case GovernorState::kEStop:
      return "emergency stop";
  }
  return "?";
}

const char* toString(SampleVerdict verdict) {
  switch (verdict) {
    case SampleVerdict::kAccepted:
      return "accepted";
    case SampleVerdict::kNotFinite:
      return "not finite";
    case SampleVerdict::kWrongLength:
      return "wrong number of joints";
    case SampleVerdict::kWrongNames:
      return "wrong joint names";
    case SampleVerdict::kRepeated:
      return "repeated";
    case SampleVerdict::kLate:
      return "overtaken by a newer one";
    case SampleVerdict::kBackwards:
      return "its clock ran backwards";
    case SampleVerdict::kTooOld:
      return "too long on its way";
    case SampleVerdict::kCount:
      break;
  }
  return "?";
}

const char* toString(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone:
      return "done";
    case Refusal::kNotConnected:
      return "no device";
    case Refusal::kEStop:
      return "emergency stop: reset first";
    case Refusal::kFault:
      return "fault: reset first";
    case Refusal::kNoFreshStream:
      return "no fresh pose";
    case Refusal::kNotMeasured:
      return "no fresh measured pose";
    case Refusal::kOutOfRange:
      return "measured far outside the limits";
    case Refusal::kMotorsOutside:
      return "a motor stands far outside its range";
    case Refusal::kMotorsOn:
      return "motors are still on";
    case Refusal::kNothingToReset:
      return "nothing to reset";
    case Refusal::kCount:
      break;
  }
  return "?";
}

const char* toString(FaultCause cause) {
  switch (cause) {
    case FaultCause::kNone:
      return "none";
    case FaultCause::kDevice:
      return "the device reports a fault";
    case FaultCause::kDeviceLost:
      return "device lost";
    case FaultCause::kDeviceSilent:
      return "device silent";
    case FaultCause::kBadMeasurement:
      return "measured pose is no pose";
    case FaultCause::kOutOfRange:
      return "measured far outside the limits";
    case FaultCause::kMotorsOutside:
      return "a motor is far outside its range";
    case FaultCause::kNoPower:
      return "motors did not go on";
    case FaultCause::kPowerLost:
      return "motors went off by themselves";
    case FaultCause::kStaysOn:
      return "motors did not go off";
    case FaultCause::kOverruns:
      return "too many late periods";
    case FaultCause::kGap:
      return "suspended under power";
    case FaultCause::kOutput:
      return "a limit was about to be broken";
    case FaultCause::kCount:
      break;
  }
  return "?";
}

const char* toString(HoldCause cause) {
  switch (cause) {
    case HoldCause::kNone:
      return "none";
    case HoldCause::kDisarmed:
      return "disarmed";
    case HoldCause::kStale:
      return "no fresh pose";
    case HoldCause::kStreamChanged:
      return "another stream began";
    case HoldCause::kMotorLimited:
      return "a motor does not obey";
  }
  return "?";
}

}  // namespace handgraft::safety
