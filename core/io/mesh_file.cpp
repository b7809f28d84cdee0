#include "core/io/mesh_file.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/ply_file.h"

namespace handgraft::io {

namespace {

FileMesh readPlyMesh(const std::filesystem::path& path) {
  PlyFile ply = readPly(path);
  for (const char* axis : {"x", "y", "z"}) {
    if (!ply.vertex.contains(axis)) {
      rejectInput("{}: PLY has no vertex property '{}'", handgraft::quoted(path.string()),
                  axis);
    }
  }
  FileMesh mesh;
  mesh.vertices.reserve(static_cast<std::size_t>(ply.vertex_count));
  for (int v = 0; v < ply.vertex_count; ++v) {
    mesh.vertices.emplace_back(ply.vertex["x"][v], ply.vertex["y"][v], ply.vertex["z"][v]);
  }
  for (Eigen::Index f = 0; f < ply.faces.cols(); ++f) {
    mesh.triangles.push_back({ply.faces(0, f), ply.faces(1, f), ply.faces(2, f)});
  }
  mesh.file_face = std::move(ply.file_face);
  return mesh;
}

FileMesh readAsListed(const std::filesystem::path& path) {
  requireFile(path);
  const std::string extension = endingOf(path);
  if (extension == ".obj") return readObj(path);
  if (extension == ".stl") return readStl(path);
  if (extension == ".ply") return readPlyMesh(path);
  if (extension == ".gltf" || extension == ".glb" || extension == ".dae")
    return readScene(path);
  rejectInput("{}: mesh format {} is not known, permitted: .stl .obj .ply .gltf .glb .dae",
              handgraft::quoted(path.string()), handgraft::quoted(extension));
}

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

/// 1 for triangles of the same three corners as one before, the same way round.
std::vector<char> repeatedOf(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::array<int, 3>> corners = triangles;
  for (std::array<int, 3>& three : corners)
    std::rotate(three.begin(), std::min_element(three.begin(), three.end()), three.end());
  std::vector<std::size_t> order(triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(corners[a], a) < std::tie(corners[b], b);
  });
  std::vector<char> is_repeated(triangles.size(), 0);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_repeated[order[i]] = corners[order[i]] == corners[order[i - 1]] ? 1 : 0;
  return is_repeated;
}

/// Of a mesh as listed, by the first vertices at their places: triangles that neither collapse
/// nor are there already.
struct KeptFaces {
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> file_face;
  std::size_t collapsed = 0;
  std::size_t repeated = 0;
};

KeptFaces keptFaces(const FileMesh& listed, const std::vector<int>& first) {
  std::vector<std::array<int, 3>> triangles;
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

/// Welds, drops what collapses or is there already, and numbers the places that faces use in
/// the file's order.
MeshFile weld(const FileMesh& listed) {
  const std::vector<int> first = firstAtPlace(listed.vertices);
  MeshFile file;
  file.notes = listed.notes;
  KeptFaces kept = keptFaces(listed, first);
  const std::vector<std::array<int, 3>>& triangles = kept.triangles;
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
  std::size_t places = 0;
  for (std::size_t v = 0; v < first.size(); ++v) {
    file.mesh_vertex.push_back(place_of[first[v]]);
    unused += file.mesh_vertex.back() < 0 ? 1 : 0;
    places += first[v] == static_cast<int>(v) ? 1 : 0;
  }
  file.mesh = geometry::TriangleMesh(std::move(vertices), std::move(faces));

  if (places != listed.vertices.size()) {
    file.notes.push_back(
        fmt::format("welded {} vertices to {}", listed.vertices.size(), places));
  }
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

MeshFile readMesh(const std::filesystem::path& path) {
  const FileMesh listed = readAsListed(path);
  try {
    return weldedMesh(listed);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
