#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// How a straight walk ended.
enum class WalkEnd {
  kArrived,      ///< after the whole length
  kSurfaceEdge,  ///< where the surface ends, or at a non-manifold edge
  kStuck         ///< among faces without area, or after a million faces
};

struct StraightWalk {
  WalkEnd end = WalkEnd::kArrived;
  SurfacePoint point;
  /// Unit tangent at `point` in which the walk would go on; where it cannot, in which it came.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  double length = 0.0;  ///< walked
  /// Start, the crossings of edges and vertices, end.
  std::vector<SurfacePoint> trace;
};

/// Walks `length` along the surface without turning: leaves `start` at `heading` (rad,
/// counter-clockwise seen from outside) against `direction`, straight across edges; through a
/// vertex so that half of its angle lies on either side.
///
/// Angles are those of log maps (README of this folder): a heading is a phi, and where one
/// straight way is the shortest, walking a point's (r, phi) leads to it. Walking on from the
/// end with heading pi leads back.
///
/// Frames: direction in the mesh's; its projection onto the tangent plane counts. Units:
/// metres. Errors: InvalidInput if the start is not on the mesh, the direction is not finite,
/// zero or
///   (nearly) normal to the surface, the heading is not finite, or the length negative or not
///   finite.
/// Cost: O(1) a face crossed.
/// Source: Polthier & Schmies 1998, "Straightest Geodesics on Polyhedral Surfaces".
StraightWalk walkStraight(const TriangleMesh& mesh,
                          const SurfacePoint& start,
                          const Eigen::Vector3d& direction,
                          double length,
                          double heading = 0.0);

}  // namespace handgraft::geometry
