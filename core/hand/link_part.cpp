#include "core/hand/link_part.h"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace handgraft::hand {

namespace {

using Eigen::Vector3d;

constexpr double kDomeHeight = 0.8;  // of the radius of a cut

geometry::TriangleMesh meshOf(const std::vector<Vector3d>& vertices,
                              const std::vector<Eigen::Vector3i>& faces) {
  Eigen::Matrix3Xd columns(3, std::ssize(vertices));
  for (Eigen::Index i = 0; i < columns.cols(); ++i)
    columns.col(i) = vertices[static_cast<std::size_t>(i)];
  Eigen::Matrix3Xi triples(3, std::ssize(faces));
  for (Eigen::Index i = 0; i < triples.cols(); ++i)
    triples.col(i) = faces[static_cast<std::size_t>(i)];
  return {std::move(columns), std::move(triples)};
}

}  // namespace

geometry::TriangleMesh partOf(const Skin& skin, int link, const Pose& X_SL) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  std::vector<int> numbers(static_cast<std::size_t>(mesh_S.vertexCount()), -1);
  std::vector<Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh_S.faceCount(); ++f) {
    if (skin.faceLinks()[static_cast<std::size_t>(f)] != link) continue;
    Eigen::Vector3i face = mesh_S.face(f);
    for (int& v : face) {
      int& number = numbers[static_cast<std::size_t>(v)];
      if (number < 0) {
        number = static_cast<int>(vertices.size());
        vertices.push_back(inverse(X_SL) * mesh_S.vertex(v));
      }
      v = number;
    }
    faces.push_back(face);
  }
  return meshOf(vertices, faces);
}

geometry::TriangleMesh withDomesOnCuts(const geometry::TriangleMesh& part) {
  std::map<int, int> behind;  // along the border, as the faces at it go
  for (int h = 0; h < 3 * part.faceCount(); ++h)
    if (part.twin(h) < 0) behind[part.from(h)] = part.to(h);
  std::vector<Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  vertices.reserve(static_cast<std::size_t>(part.vertexCount()));
  faces.reserve(static_cast<std::size_t>(part.faceCount()));
  for (int v = 0; v < part.vertexCount(); ++v)
    vertices.emplace_back(part.vertex(v));
  for (int f = 0; f < part.faceCount(); ++f)
    faces.emplace_back(part.face(f));
  while (!behind.empty()) {
    std::vector<int> rim;
    for (auto at = behind.begin(); at != behind.end(); at = behind.find(rim.back())) {
      if (rim.empty()) rim.push_back(at->first);
      rim.push_back(at->second);
      behind.erase(at);
    }
    if (rim.front() != rim.back()) continue;
    rim.pop_back();
    const std::size_t count = rim.size();
    Vector3d middle = Vector3d::Zero();
    for (const int v : rim)
      middle += vertices[static_cast<std::size_t>(v)] / static_cast<double>(count);
    Vector3d area = Vector3d::Zero();
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3d a = vertices[static_cast<std::size_t>(rim[i])] - middle;
      const Vector3d b = vertices[static_cast<std::size_t>(rim[(i + 1) % count])] - middle;
      area += 0.5 * a.cross(b);
    }
    if (!(area.norm() > 0.0)) continue;
    const Vector3d height =
        -kDomeHeight * std::sqrt(area.norm() / std::numbers::pi) * area.normalized();
    // A ring half way up, and the top.
    const auto first = static_cast<int>(vertices.size());
    for (const int v : rim) {
      const Vector3d p = vertices[static_cast<std::size_t>(v)];
      vertices.emplace_back(middle + std::numbers::sqrt2 / 2.0 * (p - middle + height));
    }
    const int top = static_cast<int>(vertices.size());
    vertices.emplace_back(middle + height);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t after = (i + 1) % count;
      const int above = first + static_cast<int>(i);
      const int above_after = first + static_cast<int>(after);
      faces.emplace_back(rim[after], rim[i], above);
      faces.emplace_back(rim[after], above, above_after);
      faces.emplace_back(above_after, above, top);
    }
  }
  return meshOf(vertices, faces);
}

}  // namespace handgraft::hand
