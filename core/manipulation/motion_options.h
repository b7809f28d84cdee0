#pragma once

#include <Eigen/Core>

namespace handgraft::manipulation {

/// How patches come and go.
struct Fade {
  double seconds = 0.06;
  bool looks_ahead = true;  ///< about the time of a change; else from it on
};

/// How a motion is solved. Defaults are measured (README).
struct MotionOptions {
  /// Of |second difference|^2 a frame at 120 Hz, beside Eq. 2 of that frame; other rates count
  /// the same acceleration the same.
  double smoothness = 5e5;
  Fade fade;
  int starts = 64;    ///< of the single frames from which all others go on
  unsigned seed = 0;  ///< of those
  int threads = 1;    ///< of the offline solve
  /// Frames that the offline solve takes at once; longer motions in parts, each from the last
  /// one's end on. Memory: some 60 kB each.
  int frames_at_once = 4096;
};

/// What suits the causal solver, which pays for smoothness with delay: its caller sets it.
inline constexpr double kCausalSmoothness = 1e4;

/// How second differences of a pose weigh against each other: a joint's 1 rad (or m), which
/// moves a finger by some 5 cm, against the root's.
inline constexpr double kTurnScale = 4.0;              ///< 1/rad^2: as if at 10 cm
inline constexpr double kShiftScale = 400.0;           ///< 1/m^2
inline constexpr double kSliderScale = 400.0;          ///< 1/m^2, joints that slide
inline constexpr double kReferenceStep = 1.0 / 120.0;  // s
/// In which a hand that nothing holds comes to rest over the object, offline.
inline constexpr double kSettling = 0.25;  // s

/// Errors: InvalidInput names the value and its range.
void validate(const MotionOptions& options);

}  // namespace handgraft::manipulation
