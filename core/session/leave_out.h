#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/session/document.h"

namespace handgraft::session {

class WayTrials;

/// Leaves out patches that keep the hand off others: the palm's, or one of a finger's, without
/// which a full solve lacks fewer patches in all, what is left out counted as lacking; then
/// once more. So no fewer are reached, and no thumb is left without a patch. It is told as
/// their reason and among the notes; a root on the hand brings a patch back.
///
/// `may_go`: a flag a patch; what somebody laid himself stays. Nothing of motions.
/// Deterministic. Errors: Cancelled on wish. Cost: a solve, which need not be made again; where
/// it misses two and more a short search of each patch, and four solves a round.
void leaveOutWhatKeepsOthersOff(const std::vector<char>& may_go,
                                WayTrials& trials,
                                Document& document,
                                const Progress& progress);

}  // namespace handgraft::session
