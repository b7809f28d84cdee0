#pragma once

#include <array>
#include <vector>

#include "core/base/progress.h"
#include "core/geometry/solid.h"
#include "core/hand/hand_solid.h"
#include "core/hand/kinematics.h"
#include "core/quality/wall_penetration.h"

namespace handgraft::quality {

/// How deep one link lies in the object, at its deepest place; right through a wall: how far
/// it has to go back.
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

/// Measures two-sided: at the fine samples of the hand (some 6,000, 3-4 mm apart) in the
/// object, and at samples of the object's thin walls, sheets and edges in the links.
///
/// Depths in the object are exact distances to its surface. An object that lies within a link
/// is as deep as one place is in both. A link that goes right through a
/// wall, or a sheet, which has no inside, is as deep as it has to be moved back; to the side
/// that `sides` tell, else the shorter way. The volume counts the links' cells (1.5-3 mm) by
/// how much of them lies inside the object. Depths of walls in the hand, and of a hand in
/// itself, come from the links' grids, good to half a millimetre. Frames: `object_O` in O;
/// `pose` and X_WO in W. Errors: BrokenContract on a pose of another hand. Cancelled on wish,
/// within some 0.1 ms. Cost: 1-3 ms, the more the deeper.
Penetration measurePenetration(const hand::HandModel& model,
                               const hand::HandSolid& hand,
                               const geometry::Solid& object_O,
                               const Pose& X_WO,
                               const hand::HandPose& pose,
                               const std::vector<ContactSide>& sides = {},
                               const Progress& progress = Progress());

/// The deepest points alone.
struct Depths {
  double object_m = 0.0;  ///< in the object
  double self_m = 0.0;    ///< of one link in another that it should not meet

  bool operator==(const Depths&) const = default;
};

/// The deeper of both, each for itself: over many poses.
Depths deeperOf(const Depths& a, const Depths& b);

/// `max_depth_m` of a pose in O for less still, where a search asks again and again.
double measureDepth(const hand::HandModel& model,
                    const hand::HandSolid& hand,
                    const geometry::Solid& object_O,
                    const hand::HandPose& X_OH,
                    const Progress& progress,
                    const std::vector<ContactSide>& sides = {});

/// `max_depth_m` and `self_depth_m` of a pose in O for less: neither volumes nor objects within
/// a link.
Depths measureDepths(const hand::HandModel& model,
                     const hand::HandSolid& hand,
                     const geometry::Solid& object_O,
                     const hand::HandPose& X_OH,
                     const Progress& progress,
                     const std::vector<ContactSide>& sides = {});

}  // namespace handgraft::quality
