#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// How to walk straight from one place to another (walkStraight).
struct StraightWay {
  double heading = 0.0;  ///< against the direction given, rad
  double length = 0.0;   ///< m
  double miss = 0.0;     ///< from where the walk ends to the place meant, m
};

/// The short straight way over `mesh` from `from` to `target`: a log map tells where to head,
/// walks tell by how much that misses, and correct it, to 1e-9 of the length where such a way
/// exists.
///
/// Nothing if `target` cannot be reached, or if the best walk misses it by more than a quarter
/// of its length: where every way bends, round a notch of the surface's edge or behind a
/// saddle.
/// Errors: InvalidInput as computeLogMap. Cost: one `fast` log map of the way's length, more
///   where the way is much longer than the air line.
std::optional<StraightWay> straightWayTo(const TriangleMesh& mesh,
                                         const SurfacePoint& from,
                                         const Eigen::Vector3d& direction,
                                         const SurfacePoint& target);

}  // namespace handgraft::geometry
