#include "client/present/render/scene.h"

#include "core/base/error.h"

namespace handgraft::client::render {

std::vector<Eigen::Vector3f> Scene::points() const {
  std::vector<Eigen::Vector3f> all;
  for (const Layer& layer : layers) {
    for (const SurfaceMesh& mesh : layer.meshes) {
      all.insert(all.end(), mesh.vertices_W.begin(), mesh.vertices_W.end());
    }
  }
  for (const Segment& segment : segments) {
    all.push_back(segment.from_W);
    all.push_back(segment.to_W);
  }
  for (const Marker& marker : markers)
    all.push_back(marker.center_W);
  return all;
}

void validate(const Scene& scene) {
  for (const Layer& layer : scene.layers) {
    for (const SurfaceMesh& mesh : layer.meshes) {
      if (!mesh.vertex_colors.empty() && mesh.vertex_colors.size() != mesh.vertices_W.size()) {
        rejectInput("a mesh has {} colours for {} vertices", mesh.vertex_colors.size(),
                    mesh.vertices_W.size());
      }
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const std::uint32_t vertex : mesh.triangles[t]) {
          if (vertex < mesh.vertices_W.size()) continue;
          rejectInput("triangle {} of a mesh: vertex {}; the mesh has {} vertices", t, vertex,
                      mesh.vertices_W.size());
        }
      }
    }
  }
}

}  // namespace handgraft::client::render
