#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `thin-walls`: hands grasp what has hardly an inside, or none; how deep they lie in the
/// walls by touch alone, and by default.
void addThinWallsCommand(CLI::App& app);

}  // namespace handgraft::bench
