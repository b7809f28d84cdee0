#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::retargeting {

/// What no contact holds goes as the demonstrator's hand does, where the motion knows it.
///
/// Joints that move no patch which is there: as the demonstrator's posture changes from when
/// they last held one, and towards when they hold the next one; those that never hold one stand
/// as that posture looks on this hand. While nothing touches, the hand goes over the object as
/// the demonstrator's does, likewise. Joints held softly (FrameOwn) stay so.
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
