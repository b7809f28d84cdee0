#pragma once

#include <filesystem>
#include <string>

#include "core/manipulation/motion_options.h"

namespace handgraft::bench {

/// The paper's manipulation, made of the built-in library: a box is pulled off a shelf and
/// turned while fingers slide and change. Prints how each hand follows it; `picture`, where it
/// is not empty, gets a strip of frames a hand.
/// `models`: the library's folder. Errors: as the readers'.
void runBoxPull(const std::filesystem::path& models,
                const std::filesystem::path& cache,
                const std::string& picture,
                const manipulation::MotionOptions& options);

}  // namespace handgraft::bench
