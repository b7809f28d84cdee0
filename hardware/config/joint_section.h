#pragma once

#include "hardware/config/hand_config.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

inline constexpr std::size_t kMostJoints = 512;
inline constexpr double kFarthestTurn = 1000;  // rad: more than a hundred turns of a drum

/// Names and limits of `joints`, over what `motion` says of all of them. A joint whose keys are
/// in metres (`lower_m`, ...) slides. Needs nothing else of the file.
void readJoints(Section& file, HandConfig& config);

/// What each joint that slides moves by for a radian of its motor: its own `travel_m_rad`, or
/// that of the joint which leads it. Needs the transmission.
void takeTravels(Section& file, HandConfig& config);

}  // namespace handgraft::config
