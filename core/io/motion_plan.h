#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/io/mesh_file.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// Any file that a motion comes from (FORMATS.md): `handgraft-motion/1`; recorded contact
/// points; `handgraft-motion-plan/1`, which says what other files it is made of: a recording
/// and the path of its object, or two grasps and a path.
///
/// `fileOf`: where a file lies that a plan names. Indices in contact sets are the object
/// file's own. Errors: InvalidInput naming the file and the field, and what those files'
/// readers say.
manipulation::Motion readMotionFrom(
    const std::filesystem::path& path,
    const MeshFile& object,
    const std::function<std::filesystem::path(const std::string& uri)>& fileOf);

/// The object that such a file names; empty where it does not say.
std::string objectOfMotion(const std::filesystem::path& path);

}  // namespace handgraft::io
