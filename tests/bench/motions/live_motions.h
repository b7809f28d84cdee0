#pragma once

#include <memory>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/demonstration/posed_hand_motion.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"

namespace handgraft::bench {

/// The heading of what `printLive` prints.
void printLiveHeading();

/// A recorded hand followed live, frame by frame, as a session does it: how many of the
/// demonstrator's touches the hand reaches, how deep it is, what a frame takes of one core.
///
/// `contacts`: a session has some; a live hand takes nothing of them but the name.
void printLive(const contact::ContactSet& contacts,
               const std::vector<demonstration::PosedFrame>& frames,
               const std::shared_ptr<const geometry::TriangleMesh>& object_O,
               const hand::Hand& demonstrator,
               const hand::Hand& hand);

}  // namespace handgraft::bench
