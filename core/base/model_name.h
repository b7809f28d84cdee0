#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace handgraft {

/// What a server may call a model: 1-64 of these, not beginning with `.` or `-`.
inline constexpr std::size_t kLongestModelName = 64;
bool isModelNameCharacter(char c);

/// What a model is called that is read from a file, if nobody names it: the file's name without
/// its extension; characters that a model name may not have become `_`.
std::string nameFromPath(const std::filesystem::path& path);

}  // namespace handgraft
