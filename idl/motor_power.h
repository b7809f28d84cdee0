#pragma once

#include "idl/hardware.h"

/// What a bridge's status says of its motors' power.
namespace handgraft::idl {

/// False where nobody knows whether motors are off: `powered` is what the device says, and one
/// that is gone or silent says nothing.
inline bool isPowerKnown(const v1::BridgeStatus& bridge) {
  // A bridge without a hand has no motors yet.
  const bool is_away = bridge.state() == v1::BRIDGE_DISCONNECTED && !bridge.hand().empty();
  return bridge.powered() ||
         (!is_away && bridge.fault() != v1::FAULT_WIRE && bridge.fault() != v1::FAULT_SILENT);
}

}  // namespace handgraft::idl
