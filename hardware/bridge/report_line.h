#pragma once

#include <string>

#include "hardware/bridge/bridge.h"

namespace handgraft::bridge {

/// One line for people: "handgraft-bridge: armed: following session 3".
std::string textLine(const BridgeReport& report);

/// One line of JSON:
/// {"message","state","session_id","hand","names","position","target"}. Bytes that are
/// not UTF-8 become U+FFFD, numbers that are not finite null.
std::string jsonLine(const BridgeReport& report);

}  // namespace handgraft::bridge
