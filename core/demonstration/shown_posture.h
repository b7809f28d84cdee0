#pragma once

#include <vector>

#include "core/contact/contact_set.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/hand/turned_parts.h"
#include "core/manipulation/motion.h"

namespace handgraft::demonstration {

/// How the parts of a posed hand are turned. Frames: X_SO as Skin::fromWorld gives it.
std::vector<contact::PartDirection> shownPosture(const std::vector<hand::TurnedPart>& parts,
                                                 const hand::LinkPoses& X_SO);

/// The hand that demonstrates, at a frame of a motion: its palm (its base, where it has none)
/// and its posture. Frames: pose in W.
manipulation::DemonstratorKey shownAt(int frame,
                                      const hand::Hand& hand,
                                      const std::vector<hand::TurnedPart>& parts,
                                      const hand::HandPose& pose,
                                      const Pose& X_WO);

}  // namespace handgraft::demonstration
