#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/io/mesh_file.h"

namespace handgraft::io {

/// A mesh as its file lists it: nothing welded, nothing left out, polygons cut into triangles.
struct FileMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  /// Texture coordinates per vertex, u to the right and v upwards from the picture's lower left
  /// corner; NaN where a part of the scene has none, empty if none has (formats but scenes').
  std::vector<Eigen::Vector2d> uv;
  /// Colours per vertex, red green blue as the file has them, where an OBJ's `v` lines tell
  /// them; NaN of vertices without one, empty if none has one.
  std::vector<Eigen::Vector3d> rgb;
  std::vector<int> file_face;      ///< the file's face that each triangle comes from
  std::vector<std::string> notes;  ///< what looks odd, for the user
};

// Each reads one format. Errors: InvalidInput naming the file and the fault; indices are
// checked.
FileMesh readObj(const std::filesystem::path& path);
FileMesh readStl(const std::filesystem::path& path);
/// glTF, GLB and COLLADA (assimp), node transforms applied; an OBJ with its texture
/// coordinates, whose vertices are then not in the file's order.
FileMesh readScene(const std::filesystem::path& path);

/// Vertices at the same place become one, and those of open borders within 5e-4 of the mesh's
/// diagonal and a tenth of the edges there; faces without area and faces listed before go, and
/// where every face is there turned over, too, those (MeshFile says which). Errors:
/// InvalidInput for a vertex that is not finite, and where no face is left.
MeshFile weldedMesh(const FileMesh& listed);

/// Cuts a polygon into triangles of its corners, 0 to n - 1, by ear clipping in the plane of
/// its mean normal. Corners in order, 3 x n, n >= 3. Cost: O(n^2) on most polygons; large
/// ones, and those that cross themselves over and over, become fans.
std::vector<std::array<int, 3>> cutPolygon(const Eigen::Matrix3Xd& corners);

/// A number of a text file, or NaN if `word` is none. Understands `nan`, `inf` and a leading
/// plus.
double numberFrom(std::string_view word, bool& is_number);

}  // namespace handgraft::io
