#pragma once

#include <vector>

#include "core/manipulation/contact_tracker.h"

/// Joints as cameras and gloves measure them: a millimetre or two off, anew in each frame.
namespace handgraft::manipulation {

/// The standard deviation of a coordinate that is measured anew in each frame, m, about ways
/// that are smooth over five frames: by the median of fourth differences, in the object's
/// frame, so that the object's own noise counts, too. 0 of less than 16 frames. Frames:
/// joints_W and X_WO in W, times rising. Cost: O(frames log frames).
double jointNoise(const std::vector<DemonstratedFrame>& frames);

struct EvenedFrames {
  std::vector<DemonstratedFrame> frames;
  double noise_m = 0.0;  ///< that is left of it
};

/// Frames whose joints are evened out in the object's frame, each by a parabola through those
/// beside it (local regression: Cleveland 1979, here weighed by a bell curve over time): as
/// wide as it takes to leave 0.3 mm of `noise_m`, at most 60 ms (standard deviation). Fine ones
/// are left alone, to the bit. Cost: O(frames).
EvenedFrames evenedOut(std::vector<DemonstratedFrame> frames, double noise_m);

}  // namespace handgraft::manipulation
