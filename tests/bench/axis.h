#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `axis`: long patches laid onto skins from a single root and along an axis, side by side.
void addAxisCommand(CLI::App& app);

}  // namespace handgraft::bench
