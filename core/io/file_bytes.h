#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace handgraft::io {

/// Its size. Errors: InvalidInput naming the file if it is missing, a folder, empty or larger
/// than 4 GiB.
std::uintmax_t requireFile(const std::filesystem::path& path);

/// A name's ending in lower case, `.obj`; empty: it has none.
std::string endingOf(const std::filesystem::path& path);

/// The whole file. Errors: as requireFile, and if it cannot be read.
std::string readFileBytes(const std::filesystem::path& path);

}  // namespace handgraft::io
