#pragma once

#include <string>
#include <vector>

namespace handgraft {

/// What to tell who recorded these times (s, rising): frames of a hand that are several seconds
/// apart seem to be counted in milliseconds, microseconds or nanoseconds. Empty: nothing to
/// tell, as of a few frames. Cost: linear.
std::string timeUnitNote(const std::vector<double>& time_s);

/// What to tell whose tracker lost sight, by the times (s, rising) of its frames: gaps of a
/// tenth of a second and more, and five times as long as most. Empty: there are none, as in a
/// few frames. Cost: linear.
std::string timeGapNote(const std::vector<double>& time_s);

}  // namespace handgraft
