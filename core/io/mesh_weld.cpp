#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/kd_tree.h"
#include "core/io/file_mesh.h"

namespace handgraft::io {

namespace {

/// For every vertex the first one at exactly its place.
std::vector<int> firstAtPlace(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<int> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int v) {
    return std::tuple(vertices[v].x(), vertices[v].y(), vertices[v].z());
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::tuple_cat(key(a), std::tuple(a)) < std::tuple_cat(key(b), std::tuple(b));
  });
  std::vector<int> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

std::size_t ownCount(const std::vector<int>& first) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < first.size(); ++v)
    count += first[v] == static_cast<int>(v) ? 1 : 0;
  return count;
}

using Triangles = std::vector<std::array<int, 3>>;

/// Those of the same corners beside each other, each group in the file's order.
std::vector<std::size_t> grouped(const Triangles& corners) {
  std::vector<std::size_t> order(corners.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(corners[a], a) < std::tie(corners[b], b);
  });
  return order;
}

/// 1 for triangles of the same three corners as one before, the same way round.
std::vector<char> repeatedOf(const Triangles& triangles) {
  Triangles corners = triangles;
  for (std::array<int, 3>& three : corners)
    std::rotate(three.begin(), std::min_element(three.begin(), three.end()), three.end());
  const std::vector<std::size_t> order = grouped(corners);
  std::vector<char> is_repeated(triangles.size(), 0);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_repeated[order[i]] = corners[order[i]] == corners[order[i - 1]] ? 1 : 0;
  return is_repeated;
}

/// Of a mesh as listed, by the first vertices at their places: triangles that neither collapse
/// nor are there already.
struct KeptFaces {
  Triangles triangles;
  std::vector<int> file_face;
  std::size_t collapsed = 0;
  std::size_t repeated = 0;
};

KeptFaces keptFaces(const FileMesh& listed, const std::vector<int>& first) {
  Triangles triangles;
  std::vector<int> file_face;
  for (std::size_t t = 0; t < listed.triangles.size(); ++t) {
    std::array<int, 3> corners = listed.triangles[t];
    for (int& corner : corners)
      corner = first[corner];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
      continue;
    triangles.push_back(corners);
    file_face.push_back(listed.file_face[t]);
  }
  const std::vector<char> is_repeated = repeatedOf(triangles);
  KeptFaces kept;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (is_repeated[t] != 0) continue;
    kept.triangles.push_back(triangles[t]);
    kept.file_face.push_back(file_face[t]);
  }
  kept.collapsed = listed.triangles.size() - triangles.size();
  kept.repeated = triangles.size() - kept.triangles.size();
  return kept;
}

/// Vertices at the ends of edges that one face alone has, whichever way round it is, in rising
/// order.
std::vector<int> borderOf(const Triangles& triangles) {
  std::vector<std::uint64_t> edges;  // both ends in one number, which sorts three times as fast
  edges.reserve(3 * triangles.size());
  for (const std::array<int, 3>& corners : triangles) {
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(corners[c], corners[(c + 1) % 3]);
      edges.push_back(static_cast<std::uint64_t>(low) << 32U |
                      static_cast<std::uint64_t>(high));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<int> border;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (e > 0 && edges[e - 1] == edges[e]) continue;
    if (e + 1 < edges.size() && edges[e + 1] == edges[e]) continue;
    border.push_back(static_cast<int>(edges[e] >> 32U));
    border.push_back(static_cast<int>(edges[e] & 0xffffffffU));
  }
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  return border;
}

/// Pieces that were computed apart meet within a rounding: 0.1 mm of a bottle, if their edges
/// are ten times as long.
constexpr double kNear = 5e-4;       // of the diagonal
constexpr double kNearOfEdge = 0.1;  // of the shortest edge there

double diagonalOf(const std::vector<Eigen::Vector3d>& vertices) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : vertices)
    box.extend(p);
  return box.diagonal().norm();
}

/// How far each vertex may move, at most `most`.
std::vector<double> reachOf(const FileMesh& listed, const Triangles& triangles, double most) {
  std::vector<double> reach(listed.vertices.size(), most);
  for (const std::array<int, 3>& corners : triangles) {
    for (int c = 0; c < 3; ++c) {
      const int a = corners[c];
      const int b = corners[(c + 1) % 3];
      const double share = kNearOfEdge * (listed.vertices[a] - listed.vertices[b]).norm();
      reach[a] = std::min(reach[a], share);
      reach[b] = std::min(reach[b], share);
    }
  }
  return reach;
}

struct NearJoined {
  std::size_t count = 0;
  double farthest = 0.0;  ///< in the file's units
};

/// Lets vertices of the border be the first one near them. Inner ones stay: what is closed is
/// not changed, however fine it is.
NearJoined joinNear(const FileMesh& listed,
                    const Triangles& triangles,
                    std::vector<int>& first) {
  NearJoined joined;
  const std::vector<int> border = borderOf(triangles);
  const double most = kNear * diagonalOf(listed.vertices);
  if (border.empty() || !std::isfinite(most)) return joined;
  const std::vector<double> reach = reachOf(listed, triangles, most);
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(border.size()));
  for (std::size_t b = 0; b < border.size(); ++b)
    places.col(static_cast<Eigen::Index>(b)) = listed.vertices[border[b]];
  const geometry::KdTree tree(places);
  std::vector<char> is_taken(first.size(), 0);
  std::vector<int> now(first.size());
  std::iota(now.begin(), now.end(), 0);
  for (std::size_t b = 0; b < border.size(); ++b) {
    const int v = border[b];
    if (is_taken[v] != 0) continue;
    for (const auto& hit : tree.within(listed.vertices[v], reach[v])) {
      const int other = border[hit.index];
      if (other <= v || is_taken[other] != 0 || hit.distance > reach[other]) continue;
      is_taken[other] = 1;
      now[other] = v;
      ++joined.count;
      joined.farthest = std::max(joined.farthest, hit.distance);
    }
  }
  for (int& v : first)
    v = now[v];
  return joined;
}

/// Both sides of every face, as what draws lists them for a renderer that shows fronts alone:
/// the first of each two stays, and the surface is one again. Turned faces of a part of the
/// mesh stay, which may be what it is.
std::size_t dropBacks(KeptFaces& kept) {
  Triangles corners = kept.triangles;
  for (std::array<int, 3>& three : corners)
    std::sort(three.begin(), three.end());
  if (corners.size() < 4 || corners.size() % 2 != 0) return 0;  // one pair tells of no habit
  // Nearly all meshes are through here, before anything is sorted.
  if (std::find(corners.begin() + 1, corners.end(), corners.front()) == corners.end()) return 0;
  const std::vector<std::size_t> order = grouped(corners);
  std::vector<char> is_back(corners.size(), 0);
  for (std::size_t i = 0; i < order.size(); i += 2) {
    if (corners[order[i]] != corners[order[i + 1]]) return 0;
    is_back[order[i + 1]] = 1;
  }
  std::size_t fronts = 0;
  for (std::size_t t = 0; t < is_back.size(); ++t) {
    if (is_back[t] != 0) continue;
    kept.triangles[fronts] = kept.triangles[t];
    kept.file_face[fronts] = kept.file_face[t];
    ++fronts;
  }
  kept.triangles.resize(fronts);
  kept.file_face.resize(fronts);
  return fronts;
}

/// Welds, drops what collapses or is there already, and numbers the places that faces use in
/// the file's order.
MeshFile weld(const FileMesh& listed) {
  std::vector<int> first = firstAtPlace(listed.vertices);
  MeshFile file;
  file.notes = listed.notes;
  KeptFaces kept = keptFaces(listed, first);
  std::size_t backs = dropBacks(kept);
  const std::size_t places = ownCount(first);
  const NearJoined near = joinNear(listed, kept.triangles, first);
  if (near.count > 0) {
    kept = keptFaces(listed, first);
    backs = dropBacks(kept);
  }
  const Triangles& triangles = kept.triangles;
  file.file_face = std::move(kept.file_face);
  std::vector<int> place_of(listed.vertices.size(), -1);
  for (const std::array<int, 3>& corners : triangles)
    for (const int corner : corners)
      place_of[corner] = 0;
  for (std::size_t v = 0; v < place_of.size(); ++v) {
    if (place_of[v] < 0) continue;
    place_of[v] = static_cast<int>(file.file_vertex.size());
    file.file_vertex.push_back(static_cast<int>(v));
  }

  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(file.file_vertex.size()));
  for (std::size_t v = 0; v < file.file_vertex.size(); ++v) {
    vertices.col(static_cast<Eigen::Index>(v)) = listed.vertices[file.file_vertex[v]];
  }
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      faces(c, static_cast<Eigen::Index>(t)) = place_of[triangles[t][c]];
    }
  }
  int unused = 0;
  for (std::size_t v = 0; v < first.size(); ++v) {
    file.mesh_vertex.push_back(place_of[first[v]]);
    unused += file.mesh_vertex.back() < 0 ? 1 : 0;
  }
  file.mesh = geometry::TriangleMesh(std::move(vertices), std::move(faces));

  if (places != listed.vertices.size()) {
    file.notes.push_back(
        fmt::format("welded {} vertices to {}", listed.vertices.size(), places));
  }
  if (near.count > 0) {
    file.notes.push_back(
        fmt::format("joined {} border vertices, {:.2g} apart at most in the file's units",
                    near.count, near.farthest));
  }
  if (backs > 0)
    file.notes.push_back(fmt::format("dropped {} faces that are others turned over", backs));
  if (kept.collapsed > 0)
    file.notes.push_back(fmt::format("dropped {} faces without area", kept.collapsed));
  if (kept.repeated > 0)
    file.notes.push_back(fmt::format("dropped {} faces that are listed before", kept.repeated));
  if (unused > 0)
    file.notes.push_back(fmt::format("left out {} vertices without a face", unused));
  return file;
}

}  // namespace

MeshFile weldedMesh(const FileMesh& listed) {
  for (std::size_t v = 0; v < listed.vertices.size(); ++v) {
    const Eigen::Vector3d& p = listed.vertices[v];
    if (!p.allFinite()) {
      rejectInput("vertex {} is ({}, {}, {}), coordinates must be finite", v, p[0], p[1], p[2]);
    }
  }
  MeshFile file = weld(listed);
  if (file.mesh.faceCount() == 0) rejectInput("has no face with area");
  return file;
}

}  // namespace handgraft::io
