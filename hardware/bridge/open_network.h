#pragma once

#include <optional>

#include "core/base/network.h"
#include "hardware/config/hand_config.h"

namespace handgraft::bridge {

/// Whoever is on an open network may reset, arm and move a hand there, since nobody is asked
/// who he is: motors are driven on the loopback alone, unless somebody said that it be so, or
/// the domain is secured.
/// Errors: InvalidInput for a config with motors off the loopback that is not `permitted`.
void requireClosedNetwork(const NetworkInterface& interface,
                          const std::optional<config::HandConfig>& config,
                          bool permitted);

}  // namespace handgraft::bridge
