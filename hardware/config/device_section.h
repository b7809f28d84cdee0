#pragma once

#include "hardware/config/hand_config.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

/// `device` of a hand's file: its kind, its wire, and the keys that devices of its kind have.
DeviceConfig readDevice(Section section);

}  // namespace handgraft::config
