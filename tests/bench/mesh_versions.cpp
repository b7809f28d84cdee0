#include "tests/bench/mesh_versions.h"

#include <algorithm>
#include <set>
#include <utility>

namespace handgraft::bench {

namespace {

using geometry::TriangleMesh;

bool isObtuse(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return (b - a).dot(c - a) < 0.0 || (a - b).dot(c - b) < 0.0 || (a - c).dot(b - c) < 0.0;
}

}  // namespace

NeedledMesh withNeedles(const TriangleMesh& mesh, std::mt19937& random) {
  constexpr double kHeight = 0.01;  // of the needle, as a share of its face's height
  std::vector<geometry::SurfacePoint> added;
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    if ((random() & 1U) != 0) {
      faces.push_back(mesh.face(f));
      continue;
    }
    const int apex = static_cast<int>(random() % 3);
    Eigen::Vector3d weights = Eigen::Vector3d::Constant((1.0 - kHeight) / 2.0);
    weights[apex] = kHeight;
    const int middle = mesh.vertexCount() + static_cast<int>(added.size());
    added.push_back({f, weights});
    for (int corner = 0; corner < 3; ++corner) {
      Eigen::Vector3i face = mesh.face(f);
      face[corner] = middle;
      faces.push_back(face);
    }
  }
  Eigen::Matrix3Xd vertices(3, mesh.vertexCount() + static_cast<int>(added.size()));
  vertices.leftCols(mesh.vertexCount()) = mesh.vertices();
  for (std::size_t i = 0; i < added.size(); ++i) {
    vertices.col(mesh.vertexCount() + static_cast<int>(i)) = positionOf(mesh, added[i]);
  }
  Eigen::Matrix3Xi corners(3, static_cast<int>(faces.size()));
  for (std::size_t f = 0; f < faces.size(); ++f)
    corners.col(static_cast<int>(f)) = faces[f];
  return {TriangleMesh(std::move(vertices), std::move(corners)), std::move(added)};
}

TriangleMesh flippedToObtuse(const TriangleMesh& mesh) {
  std::vector<bool> taken(static_cast<std::size_t>(mesh.faceCount()), false);
  // A flip may not make an edge that exists.
  std::set<std::pair<int, int>> made;
  const auto joined = [&](int a, int b) {
    for (const int* h = mesh.outgoingBegin(a); h != mesh.outgoingEnd(a); ++h) {
      if (mesh.to(*h) == b || mesh.from(TriangleMesh::previous(*h)) == b) return true;
    }
    return made.count(std::minmax({a, b})) != 0;
  };
  Eigen::Matrix3Xi faces = mesh.faces();
  for (int h = 0; h < 3 * mesh.faceCount(); ++h) {
    const int twin = mesh.twin(h);
    if (twin < 0) continue;
    const auto face = static_cast<std::size_t>(TriangleMesh::faceOf(h));
    const auto other = static_cast<std::size_t>(TriangleMesh::faceOf(twin));
    if (taken[face] || taken[other]) continue;
    const int a = mesh.from(h);
    const int b = mesh.to(h);
    const int c = mesh.from(TriangleMesh::previous(h));
    const int d = mesh.from(TriangleMesh::previous(twin));
    const Eigen::Vector3d p_a = mesh.vertex(a);
    const Eigen::Vector3d p_b = mesh.vertex(b);
    const Eigen::Vector3d p_c = mesh.vertex(c);
    const Eigen::Vector3d p_d = mesh.vertex(d);
    const Eigen::Vector3d normal = mesh.faceNormals().col(static_cast<int>(face)) +
                                   mesh.faceNormals().col(static_cast<int>(other));
    const bool convex = (p_d - p_a).cross(p_c - p_a).dot(normal) > 0.0 &&
                        (p_c - p_b).cross(p_d - p_b).dot(normal) > 0.0;
    if (!convex || !isObtuse(p_a, p_d, p_c) || !isObtuse(p_b, p_c, p_d) || joined(c, d))
      continue;
    faces.col(static_cast<int>(face)) << a, d, c;
    faces.col(static_cast<int>(other)) << b, c, d;
    taken[face] = taken[other] = true;
    made.insert(std::minmax({c, d}));
  }
  return {mesh.vertices(), faces};
}

double obtuseShare(const TriangleMesh& mesh) {
  int count = 0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    count += isObtuse(mesh.vertex(face[0]), mesh.vertex(face[1]), mesh.vertex(face[2])) ? 1 : 0;
  }
  return static_cast<double>(count) / mesh.faceCount();
}

}  // namespace handgraft::bench
