#pragma once

#include <string>
#include <vector>

#include "idl/hardware.h"

namespace handgraft::client {

/// What to tell who had motors switched off of which nobody knows whether they are.
std::string powerNotKnownText(const v1::BridgeStatus& bridge);

/// For people: a paragraph a bridge.
std::string statusText(const std::vector<v1::BridgeStatus>& bridges);

/// Why a bridge did not do as it was told: its state, and what it refused; once where both say
/// the same.
std::string whyNotText(const v1::BridgeStatus& bridge);

/// {"bridges": [...]}: every field of each status, in SI units as on the wire.
std::string statusJson(const std::vector<v1::BridgeStatus>& bridges);

}  // namespace handgraft::client
