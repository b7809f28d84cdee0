#pragma once

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/hand_model.h"
#include "core/session/hand_placement.h"

namespace handgraft::session {

/// The direction of an anchor as a hand in `pose` shows it on the object: its own direction,
/// seen in O and laid into the tangent plane at the patch's root.
Eigen::Vector3d directionShownBy(const hand::HandModel& model,
                                 const hand::HandPose& pose,
                                 const Anchor& anchor,
                                 const geometry::TriangleMesh& object_O,
                                 const geometry::SurfacePoint& root_O,
                                 const Pose& X_WO);

}  // namespace handgraft::session
