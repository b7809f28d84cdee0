#pragma once

#include <filesystem>
#include <string>

namespace handgraft::client {

/// The whole of a session's file, to be sent in one request.
/// Errors: InvalidInput, naming the file, if it cannot be read, or its size and what a request
/// carries.
std::string readSessionText(const std::filesystem::path& path);

}  // namespace handgraft::client
