#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `solve PROBLEM.json`: one problem, one JSON line.
void addSolveCommand(CLI::App& app);

/// `solvers DIR`: every solver over a folder of problems, side by side with `reference.json`.
void addSolversCommand(CLI::App& app);

}  // namespace handgraft::bench
