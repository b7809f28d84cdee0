#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

namespace handgraft::session {

/// The place of the skin that a posed hand shows to a place of an object: the middle of the
/// nearest face that looks at it, among those of the permitted links; nothing if none does.
///
/// Shapes: `permitted` one flag a link. Frames: pose and place in W, `n_W` the object's outward
/// unit normal there. Cost: O(F).
std::optional<geometry::SurfacePoint> rootShownBy(const hand::HandModel& model,
                                                  const hand::Skin& skin,
                                                  const hand::HandPose& pose,
                                                  const std::vector<char>& permitted,
                                                  const Eigen::Vector3d& p_W,
                                                  const Eigen::Vector3d& n_W);

}  // namespace handgraft::session
