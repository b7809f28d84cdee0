#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

/// The surfaces of all links in one mesh, and which link each face belongs to.
struct LinkSurfaces {
  geometry::TriangleMesh mesh_A;
  std::vector<int> face_links;
};

/// Which of a link's two sets of shapes stands for its surface; a link that lacks the one asked
/// for shows the other.
enum class SurfaceSource { kVisuals, kCollisions };

const std::vector<Shape>& surfaceOf(const Link& link, SurfaceSource source);

/// Gathers the links' surfaces at the link poses `X_AL`, in frame A. No face if no link has a
/// surface. Cost: linear in the faces.
LinkSurfaces linkSurfaces(const HandModel& model,
                          const LinkPoses& X_AL,
                          SurfaceSource source = SurfaceSource::kVisuals);

}  // namespace handgraft::hand
