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

/// Gathers the links' surfaces at the link poses `X_AL`, in frame A. No face if no link has a
/// surface. Cost: linear in the faces.
LinkSurfaces linkSurfaces(const HandModel& model, const LinkPoses& X_AL);

}  // namespace handgraft::hand
