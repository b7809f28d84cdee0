#pragma once

#include <map>
#include <string>

#include "core/hand/hand_model.h"

namespace handgraft::io {

/// A URDF of the hand's links and joints alone, without surfaces: for hands whose own file does
/// not describe them, as mirrored ones. `comment` is put at its top; `efforts` are the joints'
/// effort limits by name (urdf_text.h), 0 where there is none, since URDF demands one.
///
/// What `readUrdfKinematics` makes of it has the same names, order, limits and mimics, and the
/// same link poses to 1e-12. Cost: O(links).
std::string kinematicUrdfText(const hand::HandModel& model,
                              const std::string& comment,
                              const std::map<std::string, double>& efforts = {});

}  // namespace handgraft::io
