#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/contact_tracker.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// Reads a posed human hand over time, `handgraft-demonstration/1` (FORMATS.md): 21 joints a
/// frame or MANO's parameters, and the object's pose; or the same as NumPy's `.npz`, by these
/// names or those that MANO sequences go by.
/// Errors: InvalidInput naming the file, the field and the frame.
std::vector<manipulation::DemonstratedFrame> readDemonstration(
    const std::filesystem::path& path);

/// The object that a `.npz` names; empty where it does not say. Errors: InvalidInput.
std::string objectOfNpz(const std::filesystem::path& path);

/// The same as a motion (motionOfDemonstration), called after the file.
manipulation::Motion readDemonstratedMotion(const std::filesystem::path& path,
                                            const geometry::TriangleMesh& object_O);

}  // namespace handgraft::io
