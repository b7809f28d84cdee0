#pragma once

#include <filesystem>
#include <vector>

#include "core/demonstration/posed_hand_motion.h"
#include "core/hand/hand_model.h"

#include "tests/bench/motions/live_motions.h"
#include "tests/bench/retargeting/demonstration.h"

namespace handgraft::bench {

/// Draws a recorded grasp that a hand followed live: above the demonstrator, below the hand, at
/// four times from where the fingers have closed to the end, as FOLDER/GRASP_HAND.png.
///
/// `shown`: what the hand did, one a frame. Errors: InvalidInput if the file
/// cannot be written. Cost: about two seconds.
void drawLiveGrasp(const std::filesystem::path& folder,
                   const Demonstration& grasp,
                   const hand::HandModel& demonstrator,
                   const hand::HandModel& hand,
                   const std::vector<demonstration::PosedFrame>& frames,
                   const std::vector<LiveFrame>& shown);

}  // namespace handgraft::bench
