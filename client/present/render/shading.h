#pragma once

#include <Eigen/Core>

#include "client/present/render/camera.h"
#include "client/present/render/image.h"

namespace handgraft::client::render {

/// The light of a picture: from the upper left behind the viewer, on both sides of a surface,
/// with darker outlines and a small highlight.
class Lights {
 public:
  /// Keeps a reference to the camera.
  explicit Lights(const Camera& camera);

  /// The colour that a surface of this own colour shows at `p_W`, where its unit normal is
  /// `n_W`.
  [[nodiscard]] Color lit(const Color& color,
                          const Eigen::Vector3f& p_W,
                          const Eigen::Vector3f& n_W) const;

 private:
  const Camera& camera_;
  Eigen::Vector3f key_W_;  // towards the light
  Eigen::Vector3f up_W_;
};

}  // namespace handgraft::client::render
