#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace handgraft::io {

/// A PLY as it stands: all scalar vertex properties, faces triangulated as fans, comments.
struct PlyFile {
  std::vector<std::string> comments;
  int vertex_count = 0;
  /// Property name to one value per vertex, in the file's order: x, y, z, contact, link, red
  /// ...
  std::map<std::string, Eigen::VectorXd> vertex;
  Eigen::Matrix3Xi faces;
  /// Names of the faces' scalar properties, whose values are not kept.
  std::vector<std::string> face_properties;
  /// The file's face that each triangle comes from.
  std::vector<int> file_face;
};

/// Reads ascii and binary PLY of both endiannesses; elements and list properties it does not
/// know are skipped. Errors: InvalidInput naming the file and the fault (truncated, bad header,
/// index out of range); claims in the header are checked against the file's size before memory
/// is taken.
PlyFile readPly(const std::filesystem::path& path);

}  // namespace handgraft::io
