#pragma once

#include <vector>

#include "core/geometry/log_mapper.h"

namespace handgraft::transfer {

/// The log map of a disk about `source` that holds all `targets` which can be reached.
///
/// Guesses the radius from the straight-line distances and the turn of the normals; where that
/// falls short, paths along edges bound it, and the second map holds all that hangs together
/// with the source. Frames: direction in the mesh's. Cost: one log map, seldom two.
geometry::LogMap diskAround(const geometry::LogMapper& maps,
                            const geometry::SurfacePoint& source,
                            const Eigen::Vector3d& direction,
                            const std::vector<geometry::SurfacePoint>& targets,
                            geometry::LogMapMethod method);

}  // namespace handgraft::transfer
