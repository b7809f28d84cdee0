#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/geometry/triangle_mesh.h"
#include "core/io/motion_plan.h"
#include "core/manipulation/motion.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// The contact areas of what a hand did, over time (core/demonstration/posed_hand_motion.h).
///
/// `object`: what it is called; another name in the file is noted. Joints that the file does
/// not name stay at rest, which is noted, those that follow others are left out, and values
/// beyond limits are taken and noted, as of one pose (pose_contacts.h). Errors: InvalidInput as
/// there, for how often contacts are cut outside 1 ms to 10 s, and for a hand that never
/// touches; Cancelled. Cost: a tenth of a second a cut on dense scans.
manipulation::Motion motionOfTrajectory(const io::HandTrajectoryPlan& plan,
                                        const StoredHand& hand,
                                        const std::string& object,
                                        const geometry::TriangleMesh& object_O,
                                        const Progress& progress);

}  // namespace handgraft::server
