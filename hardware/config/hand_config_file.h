#pragma once

#include <filesystem>
#include <string>

#include "hardware/config/hand_config.h"

namespace handgraft::config {

/// Reads everything about one hand (YAML `handgraft-hardware/1`; README of this folder), its
/// calibration file included, and checks it as a whole. A hand that can be homed may be without
/// its calibration file as yet.
/// Errors: InvalidInput that names the file and everything that is wrong with it, each with its
/// key and what is permitted, joined by "; ". Unknown keys are wrong.
HandConfig readHandConfig(const std::filesystem::path& path);

/// The same from a text; its calibration file is not read.
HandConfig parseHandConfig(const std::string& text);

}  // namespace handgraft::config
