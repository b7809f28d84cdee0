#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `chain`: hands by their URDF alone grasp objects by scanned contact alone, every step by its
/// defaults.
void addChainCommand(CLI::App& app);

}  // namespace handgraft::bench
