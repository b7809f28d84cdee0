#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/hand/hand_model.h"
#include "core/session/hand_placement.h"

namespace handgraft::session {

/// The unit tangent of the surface at `point` nearest to `direction`; nothing where the
/// direction is along the normal. Frames: the mesh's own.
std::optional<Eigen::Vector3d> tangentAt(const geometry::TriangleMesh& mesh,
                                         const geometry::SurfacePoint& point,
                                         const Eigen::Vector3d& direction);

/// Some unit tangent at `point`, the same for the same mesh.
Eigen::Vector3d anyTangentAt(const geometry::TriangleMesh& mesh,
                             const geometry::SurfacePoint& point);

/// `direction`, a tangent at `from`, taken along to `to` by the smallest rotation between the
/// two normals: a unit tangent there.
Eigen::Vector3d tangentCarried(const geometry::TriangleMesh& mesh,
                               const geometry::SurfacePoint& from,
                               const geometry::SurfacePoint& to,
                               const Eigen::Vector3d& direction);

/// The direction of an anchor as a hand in `pose` shows it on the object: its own direction,
/// seen in O and laid into the tangent plane at the patch's root.
Eigen::Vector3d directionShownBy(const hand::HandModel& model,
                                 const hand::HandPose& pose,
                                 const Anchor& anchor,
                                 const geometry::TriangleMesh& object_O,
                                 const geometry::SurfacePoint& root_O,
                                 const Pose& X_WO);

}  // namespace handgraft::session
