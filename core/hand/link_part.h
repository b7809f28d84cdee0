#pragma once

#include "core/base/pose.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// The part of the skin that belongs to a link, in its frame; open where it was cut off.
/// Cost: O(faces of the skin).
geometry::TriangleMesh partOf(const Skin& skin, int link, const Pose& X_SL);

/// The part with a dome over each cut, as a knuckle ends: the link goes on in there, under its
/// neighbour's skin. With flat cuts a rim that stood between two links was hardly in either.
/// Rims that are no single loop stay open. Cost: O(F log F).
geometry::TriangleMesh withDomesOnCuts(const geometry::TriangleMesh& part);

}  // namespace handgraft::hand
