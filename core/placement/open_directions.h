#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/hand_model.h"
#include "core/hand/skin.h"
#include "core/placement/hand_pose_guess.h"

namespace handgraft::placement {

/// The direction of an anchor as a hand in `pose` shows it on the object: its own direction,
/// seen in O and laid into the tangent plane at the patch's root.
Eigen::Vector3d directionShownBy(const hand::HandModel& model,
                                 const hand::HandPose& pose,
                                 const Anchor& anchor,
                                 const geometry::TriangleMesh& object_O,
                                 const geometry::SurfacePoint& root_O,
                                 const Pose& X_WO);

/// The other way round: the object's direction d_W as a posed hand (X_SW: Skin::fromWorld of
/// its pose) shows it at a place of its skin, turned away from the finger's bone by `most_rad`
/// at most. `bone_S` is the unit tangent along the bone there. Nothing where d_W stands on the
/// skin, or on faces of no link.
std::optional<Eigen::Vector3d> skinDirectionShownBy(const hand::Skin& skin,
                                                    const hand::LinkPoses& X_SW,
                                                    const geometry::SurfacePoint& root_S,
                                                    const Eigen::Vector3d& bone_S,
                                                    const Eigen::Vector3d& d_W,
                                                    double most_rad);

}  // namespace handgraft::placement
