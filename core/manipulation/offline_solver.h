#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::manipulation {

/// All frames at once (motion_objective.h): a damped Newton method over the band of frames, the
/// joints within their limits by an active set, out of the object by more and more of what
/// Avoidance charges.
///
/// Starts from the best single frames at contact changes, joined so that no finger jumps
/// (motion_starts.h), or from `start`, a pose a frame, which is then not moved far.
///
/// Determinism: the same bytes on any number of threads. Errors: InvalidInput if the problem or
/// the options are not valid; Cancelled on wish. Cost: linear in the frames.
Trajectory solveOffline(const MotionProblem& problem,
                        const MotionOptions& options,
                        const Progress& progress,
                        const std::vector<hand::HandPose>& start = {});

}  // namespace handgraft::manipulation
