#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::manipulation {

/// A pose a frame to set out from: at contact changes, some 0.25 s apart, the best single-frame
/// minima and those that lead on from the neighbours', one of each chosen by dynamic
/// programming over what the frames between would cost (Simpson's rule) and the bend that the
/// way takes at least; between them poses are interpolated. Penetration counts for nothing.
///
/// Deterministic. Errors: Cancelled on wish. Cost: some 5 ms a change.
std::vector<hand::HandPose> joinedMinima(const MotionProblem& problem,
                                         const MotionOptions& options,
                                         const Progress& progress);

/// The same out of the object: contacts are followed frame by frame (causal_solver.h) from the
/// best minima of a few full frames, and from poses that somebody knows, towards both ends; the
/// way that is cheapest by a frame each 0.13 s counts. Deterministic. Errors: Cancelled on
/// wish. Cost: some 0.2 s, and below a millisecond a frame.
std::vector<hand::HandPose> followedMinima(const MotionProblem& problem,
                                           const MotionOptions& options,
                                           const Progress& progress,
                                           const std::vector<FramePose>& known = {});

}  // namespace handgraft::manipulation
