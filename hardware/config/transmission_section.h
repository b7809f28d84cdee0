#pragma once

#include "hardware/config/hand_config.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

/// What lies between the joints of `config`, read before, and its motors.
TransmissionConfig readTransmission(Section section, const HandConfig& config);

}  // namespace handgraft::config
