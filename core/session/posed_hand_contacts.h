#pragma once

#include "core/contact/pose_contacts.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::session {

/// The surface of each link that has one, under the link's name, where the pose puts it: what
/// contact::contactsFromPose needs of a hand.
/// Frames: pose in W, result in O. Cost: linear in the faces.
std::vector<contact::PosedSurface> posedSurfaces(const hand::HandModel& model,
                                                 const hand::HandPose& pose,
                                                 const Pose& X_WO);

}  // namespace handgraft::session
