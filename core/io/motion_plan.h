#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/io/hand_trajectory_file.h"
#include "core/io/mesh_file.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// Where a file lies that a plan names.
using FileOf = std::function<std::filesystem::path(const std::string& uri)>;

/// Any file that a motion comes from (FORMATS.md): `handgraft-motion/1`; recorded contact
/// points; `handgraft-motion-plan/1`, which says what other files it is made of: a recording
/// and the path of its object, or two grasps and a path.
///
/// Indices in contact sets are the object file's own. Errors: InvalidInput naming the file and
/// the field, and what those files' readers say; for a plan of a hand's trajectory (below).
manipulation::Motion readMotionFrom(const std::filesystem::path& path,
                                    const MeshFile& object,
                                    const FileOf& file_of);

/// A plan whose contacts are those of a hand of known joints: whoever has that hand cuts them
/// (core/demonstration).
struct HandTrajectoryPlan {
  std::string name;  ///< of the motion; empty: the file does not say
  std::string hand;
  HandTrajectoryFile trajectory;
  std::optional<double> reach_m;  ///< distance at which contact ends; missing: the default
  std::optional<double> every_s;  ///< how often contacts are cut; likewise
};

/// Nothing if the file is not such a plan. Errors: as above.
std::optional<HandTrajectoryPlan> readHandTrajectoryPlan(const std::filesystem::path& path,
                                                         const FileOf& file_of);

}  // namespace handgraft::io
