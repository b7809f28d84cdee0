#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "core/optimize/pose_solver.h"

namespace handgraft::bench {

/// What the options of the command line say; the product's own defaults where they say nothing.
struct SolveSettings {
  std::string solver{nameOf(optimize::kDefaultSolver)};
  int starts = optimize::kDefaultStarts;
  int repeat = 1;
  int threads = 1;
  unsigned seed = 0;
  bool paper = false;  ///< the paper's own way, whatever solver and starts say
};

/// Adds all settings but the solver to a command.
void addSettings(CLI::App& command, SolveSettings& settings);

struct TimedSolve {
  optimize::SolveReport report;
  std::vector<double> theta;  ///< in the order of the file's dofs, where there is one
  double ms_setup = 0.0;      ///< reading and preparing
  double ms_median = 0.0;     ///< one solve with all its starts
  double ms_least = 0.0;
  double ms_most = 0.0;
  double ms_report = 0.0;  ///< fits of all pairs at the answer
};

/// What the settings ask of the solver. Errors: InvalidInput.
optimize::SolveOptions optionsOf(const SolveSettings& settings);

/// Solves `repeat` times. On one thread its processor time counts, which other work on the
/// machine hardly disturbs; on several the time on the wall.
TimedSolve timedSolve(optimize::PoseSolver& solver, const SolveSettings& settings);

/// Reads a problem file and solves it `repeat` times; the answers are the same each time.
/// Errors: InvalidInput for the file or a setting.
TimedSolve timedSolve(const std::filesystem::path& path, const SolveSettings& settings);

}  // namespace handgraft::bench
