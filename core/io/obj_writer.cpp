#include <iterator>

#include <fmt/format.h>

#include "core/io/scene_writer.h"

namespace handgraft::io {

namespace {

/// One word: OBJ ends a group's name at a blank.
std::string word(std::string name) {
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= ' ' || c == '\\' || c == '#') c = '_';
  }
  return name.empty() ? "_" : name;
}

}  // namespace

std::string objText(const PosedGrasp& grasp) {
  std::string text = fmt::format("# {} at {}; metres, world frame, z up\n", word(grasp.hand),
                                 word(grasp.object));
  const auto out = std::back_inserter(text);
  int first = 1;
  for (const ScenePart& part : partsOf(grasp)) {
    fmt::format_to(out, "g {}\n", word(part.name));
    for (int v = 0; v < part.mesh_P.vertexCount(); ++v) {
      const Eigen::Vector3d p_W = part.X_WP * part.mesh_P.vertex(v);
      fmt::format_to(out, "v {} {} {} {} {} {}\n", p_W.x(), p_W.y(), p_W.z(), part.color[0],
                     part.color[1], part.color[2]);
    }
    for (int f = 0; f < part.mesh_P.faceCount(); ++f) {
      const Eigen::Vector3i face = part.mesh_P.face(f).array() + first;
      fmt::format_to(out, "f {} {} {}\n", face[0], face[1], face[2]);
    }
    first += part.mesh_P.vertexCount();
  }
  return text;
}

}  // namespace handgraft::io
