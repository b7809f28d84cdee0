#pragma once

#include <filesystem>
#include <string>

#include "hardware/config/hand_config.h"

namespace handgraft::config {

/// Sets each motor's zero and direction in `config` to what was found by homing (YAML
/// `handgraft-calibration/1`). Every motor must be there once, and the hand be the same.
/// Errors: InvalidInput naming the file, the motor and the key; `config` is unchanged then.
void readCalibration(const std::filesystem::path& path, HandConfig& config);

/// The same from a text.
void parseCalibration(const std::string& text, HandConfig& config);

/// The text of such a file: what `config` has now, bit for bit when it is read again.
std::string calibrationText(const HandConfig& config);

/// Errors: InvalidInput if it cannot be written.
void writeCalibration(const std::filesystem::path& path, const HandConfig& config);

}  // namespace handgraft::config
