#pragma once

#include <filesystem>
#include <optional>

#include "core/contact/finger_assignment.h"

namespace handgraft::bench {

/// The joints of the hand that made a contact map, where the data sets keep them: beside
/// `NAME_contact.ply` in `NAME.json` (ContactPose), or in `dexycb_grasps.json`, as grasp K of
/// OBJECT for `OBJECT_graspK_contact.ply`. Frames: in O.
/// Errors: InvalidInput if such a file is there and does not hold them.
std::optional<contact::HandJoints> recordedJoints(const std::filesystem::path& map);

}  // namespace handgraft::bench
