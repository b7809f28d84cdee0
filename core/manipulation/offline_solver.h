#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::manipulation {

/// All frames at once (motion_objective.h): a damped Newton method over the band of frames, the
/// joints within their limits by an active set; limits of velocity and acceleration are charged
/// from 2 % before them on, more and more. Out of an object frames 25 ms apart are searched
/// first, those between them from there. Where a limit is not kept, what lies about it is
/// searched again, all frames only if that does not help.
///
/// Starts from single frames' minima joined so that no finger jumps (motion_starts.h), out
/// of an object also from poses that somebody knows, `known`; or from `start`, a pose a frame;
/// where penetration is charged it should lie out of the object.
///
/// Motions of more than `frames_at_once` in parts: the last frames of one are solved anew with
/// the next, from its last two on, so that nothing shows where they meet.
///
/// Determinism: the same bytes on any number of threads. Errors: InvalidInput if the problem or
/// the options are not valid; Cancelled on wish. Cost: linear in the frames,
/// memory beyond the problem and the answer that of one part.
Trajectory solveOffline(const MotionProblem& problem,
                        const MotionOptions& options,
                        const Progress& progress,
                        const std::vector<hand::HandPose>& start = {},
                        const std::vector<FramePose>& known = {});

/// Frames `first` to `end` of an answer anew, from the poses that it has, after the problem
/// changed there; the others stay to the byte, and the way stays smooth where they meet.
///
/// Poses lie out of the object, and are moved into limits of their own. Determinism, errors:
/// as above. BrokenContract unless 0 <= first < end <= frames. Cost: linear in end - first.
void solveAgain(const MotionProblem& problem,
                const MotionOptions& options,
                int first,
                int end,
                const Progress& progress,
                Trajectory& trajectory);

/// A few steps downhill of a whole answer, from the poses that it has, after the problem
/// changed by little: not to its end, as solveAgain goes.
///
/// Determinism, errors, cost: as above.
void stepOn(const MotionProblem& problem,
            const MotionOptions& options,
            const Progress& progress,
            Trajectory& trajectory);

}  // namespace handgraft::manipulation
