#pragma once

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// A direction at a source that the place alone decides, so that one log map serves every
/// direction: another one is a rotation of its coordinates.
struct ReferenceAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< x axis to make the log map with
  /// phi of the wanted direction in that log map: coordinates about the wanted direction are
  /// those of the log map, turned by -angle.
  double angle = 0.0;
};

/// The reference axis at `source`, and where `wanted` lies against it.
///
/// At a vertex of several fans a direction turns every fan by another angle: there is no such
/// axis, and the answer is `wanted` itself with the angle 0.
/// Errors: InvalidInput as `layOutSource`. Cost: O(faces at the source).
ReferenceAxis referenceAxis(const TriangleMesh& mesh,
                            const SurfacePoint& source,
                            const Eigen::Vector3d& wanted);

}  // namespace handgraft::geometry
