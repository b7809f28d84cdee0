#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `transfer`: a grasp's patches onto a hand's skin, stage by stage; what an edit costs; and
/// how far a patch comes back to itself.
void addTransferCommand(CLI::App& app);

}  // namespace handgraft::bench
