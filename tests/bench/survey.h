#pragma once

#include <CLI/App.hpp>

namespace handgraft::bench {

/// `survey`: disks at random places of every mesh in some folders; what was lost and why, and
/// whether anything went wrong without a word.
void addSurveyCommand(CLI::App& app);

}  // namespace handgraft::bench
