#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `baseline DIR`: ours beside the paper's stack, problem by problem in one run.
void addBaselineCommand(CLI::App& app);

}  // namespace handgraft::bench
