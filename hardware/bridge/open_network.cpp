#include "hardware/bridge/open_network.h"

#include "core/base/error.h"

namespace handgraft::bridge {

void requireClosedNetwork(const NetworkInterface& interface,
                          const std::optional<config::HandConfig>& config,
                          bool permitted) {
  const bool has_motors = config && config->device.kind != config::DeviceKind::kSimulated;
  if (!has_motors || interface.loopback || permitted) return;
  rejectInput(
      "hand {} has motors, and interface {} ({}) is open to the network, where anybody may "
      "arm and move it: take --interface lo, secure it by --identity, or say --open if only "
      "people you trust are there",
      quoted(config->hand), interface.name, interface.address);
}

}  // namespace handgraft::bridge
