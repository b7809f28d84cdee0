#pragma once

#include <memory>

#include "core/io/trajectory_writer.h"
#include "core/manipulation/motion.h"
#include "core/retargeting/motion_solving.h"

namespace handgraft::io {

/// A hand that follows a motion, as files have it; names of hand and object are left to the
/// caller. `solved`: of that motion, which lies on `object_O`. Cost: O(pairs of all frames).
HandTrajectory trajectoryOf(const manipulation::Motion& motion,
                            const retargeting::SolvedMotion& solved,
                            std::shared_ptr<const geometry::TriangleMesh> object_O);

}  // namespace handgraft::io
