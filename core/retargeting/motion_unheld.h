#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::retargeting {

/// Has the problem prefer, weakly, poses that are turned as the demonstrator's hand is: single
/// contacts leave that open. Cost: that of placement::postureFor, and O(frames).
void turnAlike(const hand::Hand& hand,
               const manipulation::Motion& motion,
               manipulation::MotionProblem& problem);

/// What no contact holds goes as the demonstrator's hand does, where the motion knows it.
///
/// Joints that move no patch which is there stand as the demonstrator's posture looks on this
/// hand, by as much otherwise as they did when they last held one, or will, the less the longer
/// ago. While nothing holds the hand, it goes over the object as the demonstrator's does, from
/// where it was held and to where it will be; what touches with less than three patches, or
/// half of all that ever do, holds no hand. Joints held softly (FrameOwn) stay so.
///
/// Lays that into the problem's frames, and moves `poses_O`, one a frame, good where something
/// holds, there. Returns whether the motion has anything to lay. Deterministic. Cost: some 0.2
/// ms for each of the demonstrator's keys, and a look for depth for each frame without contact.
bool layUnheld(const hand::Hand& hand,
               const manipulation::Motion& motion,
               const manipulation::Fade& fade,
               const Progress& progress,
               manipulation::MotionProblem& problem,
               std::vector<hand::HandPose>& poses_O);

}  // namespace handgraft::retargeting
