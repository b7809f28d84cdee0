#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/hand/finger_coordinates.h"
#include "core/hand/skin.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/transfer_patches.h"

namespace handgraft::manipulation {

/// The pairs of a motion's points that lie on links of this very hand (PatchKey::hand_points),
/// without normals on the hand's side. A recorded point stands for a region: those of a key
/// weigh as much together as an outline's. Keys without such points, and points on links that
/// the hand does not have, are left out and noted. Errors: InvalidInput if no point is left.
TransferredMotion transferPoints(const Motion& motion,
                                 const geometry::TriangleMesh& object_O,
                                 const hand::HandModel& model);

/// The same of any hand: each point at the place that its patch tells (PatchKey::patch), or
/// where that was found to lie (PatchKey::placement), with the skin's normal there. Keys
/// without a place, or with one that this hand lacks, and
/// tracks that were dropped (PatchTrack::dropped) are left out and noted. Errors:
/// InvalidInput if no point is left; Cancelled on wish. Cost: a look at one digit's skin a key.
TransferredMotion transferPointsByPlace(const Motion& motion,
                                        const geometry::TriangleMesh& object_O,
                                        const hand::HandModel& model,
                                        const hand::Skin& skin,
                                        const hand::FingerCoordinates& coordinates,
                                        const Progress& progress);

}  // namespace handgraft::manipulation
