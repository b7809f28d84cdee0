#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `drags`: fingertips of solved grasps dragged at random to places that they can reach, and
/// edits after that: how far off they end, and what the other patches lose.
void addDragsCommand(CLI::App& app);

}  // namespace handgraft::bench
