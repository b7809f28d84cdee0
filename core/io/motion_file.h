#pragma once

#include <filesystem>
#include <string>

#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// Reads `handgraft-motion/1` (README of core/manipulation): contacts and object over time.
/// Places on the object are written as points in O and go to the nearest place of its surface.
/// Errors: InvalidInput naming the file, the track, the key and the field; a place farther than
/// kMotionReach_m from the surface; what manipulation::validate says.
/// Cost: O(points log F).
manipulation::Motion readMotion(const std::filesystem::path& path,
                                const geometry::TriangleMesh& object_O);

/// The same of a text; errors do not name a file.
manipulation::Motion motionFromText(const std::string& text,
                                    const geometry::TriangleMesh& object_O);

/// The text of such a file. What `readMotion` makes of it is the same motion, but for the
/// rounding of places. Errors: InvalidInput if the motion is not valid.
std::string motionText(const manipulation::Motion& motion,
                       const geometry::TriangleMesh& object_O);

inline constexpr double kMotionReach = 0.01;  // m

}  // namespace handgraft::io
