#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

/// The unit tangent of the surface at `point` nearest to `direction`; nothing where the
/// direction is along the normal. Frames: the mesh's own.
std::optional<Eigen::Vector3d> tangentAt(const TriangleMesh& mesh,
                                         const SurfacePoint& point,
                                         const Eigen::Vector3d& direction);

/// Some unit tangent at `point`, the same for the same mesh.
Eigen::Vector3d anyTangentAt(const TriangleMesh& mesh, const SurfacePoint& point);

/// `direction`, a tangent at `from`, taken along to `to` by the smallest rotation between the
/// two normals: a unit tangent there.
Eigen::Vector3d tangentCarried(const TriangleMesh& mesh,
                               const SurfacePoint& from,
                               const SurfacePoint& to,
                               const Eigen::Vector3d& direction);

/// `direction` turned about the normal at `point`, counter-clockwise seen from outside.
Eigen::Vector3d tangentTurned(const TriangleMesh& mesh,
                              const SurfacePoint& point,
                              const Eigen::Vector3d& direction,
                              double angle_rad);

}  // namespace handgraft::geometry
