#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace handgraft::fuzz {

/// Writes a file of this process's own, in memory where the system has such a folder; the next
/// input overwrites it. The folder is removed when the process ends well.
std::filesystem::path scratchFile(const std::string& name, std::string_view bytes);

}  // namespace handgraft::fuzz
