#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/solid.h"
#include "core/hand/hand_solid.h"

namespace handgraft::quality {

/// A place of the object that a link is to touch, from the side that n_O looks to.
struct ContactSide {
  int link = -1;
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
};

/// Where a thin wall or an edge lies deepest in a link.
struct WallPenetration {
  double depth_m = 0.0;  ///< of the wall's sample in the link: the nearest way out of the link
  Eigen::Vector3d slope_O = Eigen::Vector3d::Zero();  ///< which way that is
  /// The link goes right through the wall; then the sample that lies deepest of those.
  bool goes_through = false;
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
};

/// Looks for the object's walls in a link at X_OL.
WallPenetration wallPenetration(const hand::LinkSolid& link,
                                const geometry::Walls& walls,
                                const Pose& X_OL);

/// How far a link that goes right through a wall has to be moved to be free of it: the least
/// over a few directions, those of the wall and of the link, without such as lead away from
/// the side that it is to touch the wall from. Infinite where none of them leads out within the
/// link's own size.
///
/// Good to 0.2 mm. `sides` of all links. Cost: some milliseconds.
double wallSeparation(const hand::LinkSolid& link,
                      const geometry::Solid& object_O,
                      const Pose& X_OL,
                      const WallPenetration& wall,
                      const std::vector<ContactSide>& sides);

}  // namespace handgraft::quality
