#pragma once

#include <array>
#include <vector>

#include "core/base/progress.h"
#include "core/geometry/distance_grid.h"
#include "core/hand/hand_solid.h"
#include "core/hand/kinematics.h"

namespace handgraft::quality {

/// How deep one link lies inside the object, at its deepest place.
struct LinkDepth {
  int link = -1;
  double depth_m = 0.0;
};

/// How far a posed hand lies inside an object, and in itself.
struct Penetration {
  double max_depth_m = 0.0;  ///< of the hand in the object; 0: none
  double mean_depth_m =
      0.0;                 ///< over that part of the hand's surface that lies inside, by area
  double volume_m3 = 0.0;  ///< that both fill
  std::vector<LinkDepth> links;  ///< deepest first; those that do not penetrate are left out
  double self_depth_m = 0.0;     ///< of one link in another that it should not meet
  std::array<int, 2> self_links = {-1, -1};
};

/// Measures at the fine samples of the hand (some 4,000, 3-5 mm apart), so that a corner of the
/// object that pricks the hand between them is missed.
///
/// Depths are exact distances to the object's surface; the volume counts the links' cells
/// (2-3 mm) by how much of them lies inside the object. Depths of a hand in itself come from
/// the links' grids, good to half a millimetre.
/// Frames: `object_O` in O; `pose` and X_WO in W.
/// Errors: BrokenContract on a pose of another hand. Cancelled on wish, within some 0.1 ms.
/// Cost: 1-3 ms, the more the deeper.
Penetration measurePenetration(const hand::HandModel& model,
                               const hand::HandSolid& hand,
                               const geometry::DistanceGrid& object_O,
                               const Pose& X_WO,
                               const hand::HandPose& pose,
                               const Progress& progress = Progress());

}  // namespace handgraft::quality
