#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `logmap-speed`: all log maps on a hand's skin and on spheres, beside CGAL's exact distances
/// in the same run, and how the time grows.
void addLogMapSpeedCommand(CLI::App& app);

}  // namespace handgraft::bench
