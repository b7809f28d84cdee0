#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `logmap MESH --root-vertex V`: one log map, one JSON line, its coordinates as CSV on wish.
void addLogMapCommand(CLI::App& app);

}  // namespace handgraft::bench
