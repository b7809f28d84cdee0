#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `logmap-accuracy`: all log maps on surfaces with a closed form; a table, JSON or the table
/// of core/geometry/DECISIONS.md.
void addLogMapAccuracyCommand(CLI::App& app);

}  // namespace handgraft::bench
