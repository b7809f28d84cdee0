#pragma once

#include <cstdint>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::fuzz {

/// Asks one mesh for log maps by every method, from places inside faces, on edges and at
/// vertices, with finite and infinite radius, then for their inverses and for nearest places;
/// aborts with a line on stderr where an answer breaks what the headers promise.
///
/// `choice` picks places, directions and radii: the same mesh and choice ask the same.
/// InvalidInput is an answer. Cost: bounded by few questions a mesh; the caller bounds the
/// mesh.
void exerciseGeometry(const geometry::TriangleMesh& mesh, std::uint64_t choice);

}  // namespace handgraft::fuzz
