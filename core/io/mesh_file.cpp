#include "core/io/mesh_file.h"

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

}  // namespace

MeshFile readMesh(const std::filesystem::path& path) {
  const FileMesh listed = readAsListed(path);
  try {
    return weldedMesh(listed);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
