#pragma once

#include <filesystem>

#include "core/manipulation/motion_options.h"

namespace handgraft::bench {

/// The paper's manipulation, made of the built-in library: a box is pulled off a shelf and
/// turned while fingers slide and change. Prints how each hand follows it; `handgraft motion
/// solve --png` draws such a motion.
/// `models`: the library's folder. Errors: as the readers'.
void runBoxPull(const std::filesystem::path& models,
                const std::filesystem::path& cache,
                const manipulation::MotionOptions& options);

}  // namespace handgraft::bench
