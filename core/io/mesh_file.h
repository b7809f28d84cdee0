#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::io {

/// A mesh as read, welded, with the way back to the file's own order.
struct MeshFile {
  geometry::TriangleMesh mesh;
  /// First vertex of the file at each mesh vertex's place.
  std::vector<int> file_vertex;
  /// Mesh vertex of every vertex of the file; -1 if no face uses it.
  std::vector<int> mesh_vertex;
  /// Face of the file for every mesh face (faces that collapse in welding, and those
  /// of the same corners as one before, the same way round, are dropped).
  std::vector<int> file_face;
  /// 1 for mesh faces whose second and third corner the file lists the other way round
  /// (`readObject`); empty if there are none.
  std::vector<char> is_turned;
  /// "welded 49152 vertices to 8190", "joined 12 border vertices, 1e-06 apart at most in the
  /// file's units", "dropped 3 faces without area", "dropped 5 faces that are listed before".
  std::vector<std::string> notes;
  /// Points of a file without faces, in its order, 3 x N; then `mesh` is a surface laid through
  /// them (`readObject`) and the three lists above are empty. No column for a mesh.
  Eigen::Matrix3Xd cloud_O;
};

/// Reads STL, OBJ, PLY, glTF/GLB or DAE; welds vertices at the same place; triangulates.
///
/// Units and frames: as the file has them (node transforms applied).
/// Indices: the file's own order. An STL's vertices are its facets' corners in order; an OBJ's
/// its `v` lines; a PLY's its vertex list; other formats their meshes one after another.
/// Errors: InvalidInput, naming the file, if it is missing, truncated, not a mesh, empty, holds
/// an index out of range or a non-finite vertex (named by its file index), or claims more than
/// kMostVertices. Cost: O(V log V).
MeshFile readMesh(const std::filesystem::path& path);

/// Largest mesh accepted; bounds memory before a header's claim is believed.
inline constexpr int kMostVertices = 20'000'000;

/// Writes a binary PLY. Errors: InvalidInput if the file cannot be written.
void writePly(const std::filesystem::path& path, const geometry::TriangleMesh& mesh);

}  // namespace handgraft::io
