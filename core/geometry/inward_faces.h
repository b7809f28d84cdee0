#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// The faces of an object's mesh that look the wrong way: those that disagree with most of
/// their neighbours (by area), and the walls of a solid that is turned inside out as a whole,
/// but not those of a cavity in another one. 1 for each such face of the mesh, 0 for others;
/// empty if none does.
///
/// Limits: what has a hole wider than kOpening (signed_distance.h) has no inside to look at;
/// its faces are made to agree, no more. Units: m. Cost: O(F log F).
std::vector<char> inwardFaces(const TriangleMesh& mesh_O);

/// The mesh with the second and third corner of the chosen faces exchanged. Errors:
/// BrokenContract unless there is an entry for each face. Cost: O(F log F).
TriangleMesh withTurnedFaces(const TriangleMesh& mesh, const std::vector<char>& turned);

}  // namespace handgraft::geometry
