#pragma once

#include <filesystem>
#include <vector>

#include "idl/motions.h"

namespace handgraft::client {

/// Reads `handgraft-demonstration/1` (core/io/FORMATS.md) as the frames that a server follows:
/// times, side, joints' places or MANO's pose, the object's pose. Sessions and numbers are left
/// to whoever sends them.
/// Errors: InvalidInput naming the file, the field and the frame.
std::vector<v1::DemonstratorFrame> readDemonstration(const std::filesystem::path& path);

}  // namespace handgraft::client
