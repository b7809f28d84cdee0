#pragma once

#include <filesystem>
#include <string>

#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// The object that a `.npz` names; empty where it does not say. Errors: InvalidInput.
std::string objectOfNpz(const std::filesystem::path& path);

/// Reads a posed human hand over time, `handgraft-demonstration/1` (FORMATS.md): 21 joints a
/// frame or MANO's parameters, and the object's pose; or the same as NumPy's `.npz`, by these
/// names or those that MANO sequences go by. As a motion (motionOfDemonstration), called after
/// the file; what was left out, or seems to mean something else, is noted.
/// Errors: InvalidInput naming the file, the field and the frame.
manipulation::Motion readDemonstratedMotion(const std::filesystem::path& path,
                                            const geometry::TriangleMesh& object_O);

}  // namespace handgraft::io
