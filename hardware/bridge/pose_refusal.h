#pragma once

#include <span>
#include <string>

#include "hardware/bridge/motion_state.h"
#include "hardware/safety/governor_types.h"

namespace handgraft::bridge {

/// Why a pose was refused, for people: of joints that do not fit, the first one that is missing
/// and the first one too many. `names` are the hand's joints, `told` the pose's.
///
/// Allocates nothing. Cost: O(joints^2) for joints that do not fit.
FixedText describeRefusal(safety::SampleVerdict verdict,
                          std::span<const std::string> names,
                          std::span<const std::string> told,
                          std::size_t number_count);

}  // namespace handgraft::bridge
