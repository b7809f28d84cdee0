#pragma once

#include <Eigen/Core>

#include "idl/common.h"

namespace handgraft::client {

/// The point of a mesh that is nearest to `p`, in the mesh's own frame; the first face wins
/// where several are equally near.
/// Errors: InvalidInput for a mesh without faces; TransportError for a damaged one.
/// Cost: linear in the faces; for a click, not for many points.
v1::SurfacePoint nearestPoint(const v1::Mesh& mesh, const Eigen::Vector3d& p);

/// The place itself. Errors: TransportError if `point` is none of the mesh.
Eigen::Vector3d positionOf(const v1::Mesh& mesh, const v1::SurfacePoint& point);

/// The vertex that lies furthest along `direction`. Errors as of `nearestPoint`.
Eigen::Vector3d furthestVertex(const v1::Mesh& mesh, const Eigen::Vector3d& direction);

}  // namespace handgraft::client
