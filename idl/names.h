#pragma once

#include "idl/hardware.h"
#include "idl/models.h"
#include "idl/service.h"
#include "idl/sessions.h"

/// What the contract's enumerators are called in logs, messages and JSON. A value that is none
/// of them, which the wire may bring, is "unknown".
namespace handgraft::v1 {

/// "hand", "object" or "contacts".
const char* nameOf(ModelKind kind);

/// "put_file", "load_model", "open_session", ...
const char* nameOf(Operation operation);

/// "converged", "stalled", "evaluation_limit" or "infeasible".
const char* nameOf(Outcome outcome);

/// "none", "reached", "at_limit", "out_of_reach" or "normals_in_conflict".
const char* nameOf(Verdict verdict);

/// "open", "transferring", "optimizing", "ready", "failed" or "closed".
const char* nameOf(SessionPhase phase);

/// "disconnected", "idle", "armed", "holding", "fault" or "estop".
const char* nameOf(BridgeState state);

/// "none", "wire", "silent", "hardware", "hot", "watchdog", ...
const char* nameOf(BridgeFault fault);

}  // namespace handgraft::v1
