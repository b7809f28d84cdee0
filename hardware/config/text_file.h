#pragma once

#include <filesystem>
#include <string>

namespace handgraft::config {

/// A file of at most 1 MiB. Errors: InvalidInput naming the file.
std::string readText(const std::filesystem::path& path);

/// Replaces the file at once: a reader sees all of the old text or all of the new one.
/// Errors: InvalidInput naming the file.
void writeText(const std::filesystem::path& path, const std::string& text);

}  // namespace handgraft::config
