#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::manipulation {

/// The pairs of a motion's points that lie on links of this very hand (PatchKey::hand_points),
/// without normals on the hand's side. A recorded point stands for a region: those of a key
/// weigh as much together as an outline's. Keys without such points, and points on links that
/// the hand does not have, are left out. Errors: InvalidInput if no point is left.
std::vector<PairTrack> layPoints(const Motion& motion,
                                 const geometry::TriangleMesh& object_O,
                                 const hand::HandModel& model);

}  // namespace handgraft::manipulation
