#pragma once

#include <filesystem>
#include <string>

#include "hardware/config/hand_config.h"

namespace handgraft::config {

/// Reads everything about one hand (YAML `handgraft-hardware/1`; README of this folder), its
/// calibration file included, and checks it as a whole. The calibration file may not be there
/// as yet: then zeros are not known. Errors: InvalidInput that names the file and everything
/// that is wrong with it, each with its key and what is permitted, joined by "; ". Unknown keys
/// are wrong.
HandConfig readHandConfig(const std::filesystem::path& path);

/// The same from a text; its calibration file is not read.
HandConfig parseHandConfig(const std::string& text);

}  // namespace handgraft::config
