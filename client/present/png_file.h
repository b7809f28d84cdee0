#pragma once

#include <filesystem>

#include "client/present/render/image.h"

namespace handgraft::client {

/// Writes an 8-bit RGB PNG, as `writeFile` writes.
/// Errors: InvalidInput, naming the path and the reason, if it cannot be written.
void writePng(const std::filesystem::path& path, const render::Image& image);

}  // namespace handgraft::client
