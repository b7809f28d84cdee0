#include "client/present/render/scene.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr std::size_t kFewestFramed = 5;  // one vertex of so many

}  // namespace

void Scene::frameAbout(const SurfaceMesh& mesh,
                       float reach_m,
                       const std::vector<const SurfaceMesh*>& whole) {
  framed_W.setEmpty();
  for (const Eigen::Vector3f& p_W : mesh.vertices_W)
    if (p_W.allFinite()) framed_W.extend(p_W);
  if (framed_W.isEmpty()) return;
  framed_W.min().array() -= reach_m;
  framed_W.max().array() += reach_m;
  for (const Layer& layer : layers) {
    std::size_t all = 0;
    std::size_t framed = 0;
    for (const SurfaceMesh& other : layer.meshes) {
      all += other.vertices_W.size();
      framed += static_cast<std::size_t>(std::count_if(
          other.vertices_W.begin(), other.vertices_W.end(), [&](const Eigen::Vector3f& p_W) {
            return framed_W.contains(p_W);
          }));
    }
    if (framed * kFewestFramed < all) {
      framed_W.setEmpty();
      return;
    }
  }
  for (const SurfaceMesh* seen : whole)
    for (const Eigen::Vector3f& p_W : seen->vertices_W)
      if (p_W.allFinite()) framed_W.extend(p_W);
}

std::vector<Eigen::Vector3f> Scene::points() const {
  std::vector<Eigen::Vector3f> shown;
  const auto add = [&](const Eigen::Vector3f& p_W) {
    if (framed_W.isEmpty() || framed_W.contains(p_W)) shown.push_back(p_W);
  };
  for (const Layer& layer : layers)
    for (const SurfaceMesh& mesh : layer.meshes)
      std::for_each(mesh.vertices_W.begin(), mesh.vertices_W.end(), add);
  for (const Segment& segment : segments) {
    add(segment.from_W);
    add(segment.to_W);
  }
  for (const Marker& marker : markers)
    add(marker.center_W);
  return shown;
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
