#pragma once

#include <string>

#include "core/io/posed_grasp.h"

/// A posed grasp as one mesh file.
namespace handgraft::io {

/// Wavefront OBJ in W, metres, z up: a group `g NAME` per link and for the object, colours as
/// red, green and blue behind each vertex, so that one file is all. Coordinates are exact.
///
/// Names: blanks and control characters become `_`. Cost: O(vertices + faces).
std::string objText(const PosedGrasp& grasp);

/// Binary glTF 2.0, single precision: a node per link and for the object, each with its mesh in
/// its own frame and its pose, below a node `world` that turns our z up into glTF's y up; two
/// materials. Faces look outwards; normals are left to the reader (flat, as the standard says).
/// Cost: O(vertices + faces).
std::string glbBytes(const PosedGrasp& grasp);

}  // namespace handgraft::io
