#pragma once

#include <filesystem>

#include "core/optimize/pose_problem.h"

#include "tests/bench/retargeting/retargeted_grasp.h"

namespace handgraft::bench {

/// Draws a retargeted grasp: above the demonstrator's hand, below the hand's, each from the two
/// sides that show the patches best; patches in the same colours on both, figures beneath.
/// Errors: InvalidInput if the file cannot be written. Cost: about a second.
void drawGrasp(const std::filesystem::path& file,
               const MeasuredHand& hand,
               const MeasuredHand& demonstrator,
               const Demonstration& demonstration,
               const RetargetedGrasp& grasp);

}  // namespace handgraft::bench
