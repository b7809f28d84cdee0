#pragma once

#include <vector>

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"

namespace handgraft::manipulation {

/// A pose of the object at a time.
struct ObjectKey {
  double time_s = 0.0;
  Pose X_WO = Pose::Identity();
};

/// When patches of two grasps move, vanish and appear, as shares of the time.
struct TwoGraspOptions {
  double rate = 60.0;  ///< frames a second
  double slide_begin = 0.25;
  double slide_end = 0.75;
  double vanish = 0.4;  ///< of patches that the last grasp lacks
  double appear = 0.6;  ///< of those that the first one lacks
};

/// A motion of a first grasp, a last one, and the object's path: patches that both have, by
/// their name, go over the surface from one to the other (patch_path.h), slowly at both ends;
/// their places on the hand go along where both lie on one segment. Others vanish and appear.
///
/// The object goes from key to key along lines and turns about one axis. Sets lie on
/// `object_O`. Errors: InvalidInput for keys whose times do not rise, shares out of order or of
/// 0 to 1, a rate that makes more than kMostFrames, and as PatchPath.
Motion interpolateGrasps(const geometry::TriangleMesh& object_O,
                         const contact::ContactSet& first,
                         const contact::ContactSet& last,
                         const std::vector<ObjectKey>& path,
                         const TwoGraspOptions& options = {});

}  // namespace handgraft::manipulation
