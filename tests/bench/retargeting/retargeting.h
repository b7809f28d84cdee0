#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `retargeting`: a human's recorded grasps on every hand, all defaults, beside what is used
/// today.
void addRetargetingCommand(CLI::App& app);

}  // namespace handgraft::bench
