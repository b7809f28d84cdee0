#include "idl/names.h"

namespace handgraft::v1 {

const char* nameOf(ModelKind kind) {
  switch (kind) {
    case MODEL_HAND:
      return "hand";
    case MODEL_OBJECT:
      return "object";
    case MODEL_CONTACTS:
      return "contacts";
  }
  return "unknown";
}

const char* nameOf(Operation operation) {
  switch (operation) {
    case OP_NOTHING:
      return "nothing";
    case OP_PUT_FILE:
      return "put_file";
    case OP_LOAD_MODEL:
      return "load_model";
    case OP_LIST_MODELS:
      return "list_models";
    case OP_DESCRIBE_MODEL:
      return "describe_model";
    case OP_UNLOAD_MODEL:
      return "unload_model";
    case OP_OPEN_SESSION:
      return "open_session";
    case OP_DESCRIBE_SESSION:
      return "describe_session";
    case OP_LIST_SESSIONS:
      return "list_sessions";
    case OP_CLOSE_SESSION:
      return "close_session";
    case OP_TRANSFER:
      return "transfer";
    case OP_OPTIMIZE:
      return "optimize";
    case OP_EXPORT:
      return "export";
    case OP_CANCEL:
      return "cancel";
    case OP_SUGGEST:
      return "suggest";
    case OP_POSE_CONTACTS:
      return "pose_contacts";
    case OP_MAKE_VARIANT:
      return "make_variant";
    case OP_SWEEP:
      return "sweep";
    case OP_SESSION_SETTINGS:
      return "session_settings";
    case OP_COMPARE:
      return "compare";
    case OP_SAVE_SESSION:
      return "save_session";
    case OP_LOAD_SESSION:
      return "load_session";
    case OP_REPLAY:
      return "replay";
    case OP_STOP_SOLVING:
      return "stop_solving";
  }
  return "unknown";
}

const char* nameOf(Outcome outcome) {
  switch (outcome) {
    case OUTCOME_CONVERGED:
      return "converged";
    case OUTCOME_STALLED:
      return "stalled";
    case OUTCOME_EVALUATION_LIMIT:
      return "evaluation_limit";
    case OUTCOME_INFEASIBLE:
      return "infeasible";
  }
  return "unknown";
}

const char* nameOf(Verdict verdict) {
  switch (verdict) {
    case VERDICT_NONE:
      return "none";
    case VERDICT_REACHED:
      return "reached";
    case VERDICT_AT_LIMIT:
      return "at_limit";
    case VERDICT_OUT_OF_REACH:
      return "out_of_reach";
    case VERDICT_NORMALS_IN_CONFLICT:
      return "normals_in_conflict";
  }
  return "unknown";
}

const char* nameOf(SessionPhase phase) {
  switch (phase) {
    case PHASE_OPEN:
      return "open";
    case PHASE_TRANSFERRING:
      return "transferring";
    case PHASE_OPTIMIZING:
      return "optimizing";
    case PHASE_READY:
      return "ready";
    case PHASE_FAILED:
      return "failed";
    case PHASE_CLOSED:
      return "closed";
  }
  return "unknown";
}

const char* nameOf(BridgeState state) {
  switch (state) {
    case BRIDGE_DISCONNECTED:
      return "disconnected";
    case BRIDGE_IDLE:
      return "idle";
    case BRIDGE_ARMED:
      return "armed";
    case BRIDGE_HOLDING:
      return "holding";
    case BRIDGE_FAULT:
      return "fault";
    case BRIDGE_ESTOP:
      return "estop";
  }
  return "unknown";
}

const char* nameOf(BridgeFault fault) {
  switch (fault) {
    case FAULT_NONE:
      return "none";
    case FAULT_WIRE:
      return "wire";
    case FAULT_SILENT:
      return "silent";
    case FAULT_HARDWARE:
      return "hardware";
    case FAULT_HOT:
      return "hot";
    case FAULT_WATCHDOG:
      return "watchdog";
    case FAULT_POWER_LOST:
      return "power_lost";
    case FAULT_STARVED:
      return "starved";
    case FAULT_BAD_TARGET:
      return "bad_target";
    case FAULT_GUARD:
      return "guard";
    case FAULT_MEASUREMENT:
      return "measurement";
    case FAULT_LATE:
      return "late";
    case FAULT_CONFIG:
      return "config";
  }
  return "unknown";
}

}  // namespace handgraft::v1
