#pragma once

#include <filesystem>

namespace handgraft::bench {

/// A motion of 1,000 frames, the built-in box pulled off a shelf, edited as in a session: what
/// an edit at a time, one of all frames and an undo take, the depths of what changed included.
/// `models`: the library's folder. Errors: as the readers'.
void runMotionEdits(const std::filesystem::path& models, const std::filesystem::path& cache);

}  // namespace handgraft::bench
