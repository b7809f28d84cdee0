#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace handgraft::io {

/// The whole file. Errors: InvalidInput naming the file if it is missing, a folder, empty,
/// larger than 4 GiB or cannot be read.
std::string readFileBytes(const std::filesystem::path& path);

}  // namespace handgraft::io
