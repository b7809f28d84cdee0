#pragma once

#include <string>

#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// The left hand of a right one, and the other way round: everything reflected in the root's
/// y-z plane.
///
/// With S = diag(-1, 1, 1) and the same joint values, every link's pose is X' = S X S, and
/// every surface point p' = S p: limits, mimics, names and the rest pose stay. Mirrored twice,
/// it is the same hand. Cost: O(links + triangles).
HandModel mirrored(const HandModel& model, std::string name);

}  // namespace handgraft::hand
