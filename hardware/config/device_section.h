#pragma once

#include "hardware/config/hand_config.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

/// `device` of a hand's file: its kind, its wire, and the keys that devices of its kind have.
DeviceConfig readDevice(Section section);

/// Another port in place of the config's. A CAN bus is carried by an adapter on a tty, whose
/// name is a path, or by a network interface, whose name is none. Errors: InvalidInput for no
/// name, and for a simulated hand.
void usePort(DeviceConfig& device, const std::string& port);

}  // namespace handgraft::config
