#pragma once

#include <string>
#include <vector>

#include "core/manipulation/contact_tracker.h"

namespace handgraft::manipulation {

/// Frames of a recording, and what is odd about it.
struct RecordedFrames {
  std::vector<DemonstratedFrame> frames;  ///< at least one
  std::vector<std::string> notes;
};

/// A recording without its tracker's glitches: frames that show no hand (hand::requireHand),
/// and such as the hand or the object leaps to and comes back from, within a tenth of a second
/// and faster than 5 m/s. They are noted.
/// Errors: InvalidInput where more than a tenth of the frames show no hand, telling why the
/// first does not, or where the fingers bend backwards in the mean, as a mirrored hand's.
/// Cost: linear.
RecordedFrames withoutGlitches(std::vector<DemonstratedFrame> frames);

}  // namespace handgraft::manipulation
