#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `import`: every URDF and every contact map below folders, as they come out without a
/// hand-written file: joints, poses, skins and sites; patches and their fingers.
void addImportCommand(CLI::App& app);

}  // namespace handgraft::bench
