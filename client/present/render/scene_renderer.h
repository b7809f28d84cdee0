#pragma once

#include <vector>

#include <Eigen/Core>

#include "client/present/render/camera.h"
#include "client/present/render/decal_area.h"
#include "client/present/render/image.h"
#include "client/present/render/scene.h"

namespace handgraft::client::render {

/// Draws a scene from any number of cameras, on the CPU.
///
/// Each layer, and the opaque lines and markers together, keeps its nearest surface per sample;
/// those of all layers are blended in the order of their distance. Light falls from the upper
/// left behind the viewer on both sides of a surface. Four samples a pixel.
class SceneRenderer {
 public:
  /// Keeps a reference to the scene. Errors: InvalidInput as `validate`.
  explicit SceneRenderer(const Scene& scene);

  /// Draws over `background`, which gives the size. The camera must be made for that size.
  [[nodiscard]] Image draw(const Camera& camera, const Image& background) const;

  /// How much of each decal a viewer sees, as a share of the picture, in the order of layers
  /// and of their decals: what is nearer hides what is behind it by its opacity. One sample a
  /// pixel, no shading.
  [[nodiscard]] std::vector<double> visibleDecals(const Camera& camera,
                                                  int width,
                                                  int height) const;

  /// Of all decals together.
  [[nodiscard]] double visibleContact(const Camera& camera, int width, int height) const;

 private:
  const Scene& scene_;
  std::vector<std::vector<std::vector<Eigen::Vector3f>>>
      corner_normals_;                          // layer, mesh, corner
  std::vector<std::vector<DecalArea>> decals_;  // layer, decal
};

}  // namespace handgraft::client::render
