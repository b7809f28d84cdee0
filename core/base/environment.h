#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace handgraft {

/// A variable of the environment; empty where it is not set.
std::string environment(const char* name);

/// A user's folder by the XDG Base Directory Specification: what `variable` names, if absolute,
/// else `usual` below $HOME; none where neither says.
std::optional<std::filesystem::path> userFolder(const char* variable, const char* usual);

}  // namespace handgraft
