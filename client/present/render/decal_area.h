#pragma once

#include <vector>

#include <Eigen/Core>

#include "client/present/render/scene.h"

namespace handgraft::client::render {

/// A decal made ready to be asked about many surface points.
class DecalArea {
 public:
  explicit DecalArea(const Decal& decal);

  /// True if the decal prints on the surface with unit normal `n_W` at `p_W`. Surfaces that
  /// stand steeper than 70 degrees to the loop are left out, else it would smear along them.
  [[nodiscard]] bool covers(const Eigen::Vector3f& p_W, const Eigen::Vector3f& n_W) const;

  [[nodiscard]] const Color& color() const { return color_; }

 private:
  Eigen::Vector3f center_W_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f axis_x_W_ = Eigen::Vector3f::UnitX();
  Eigen::Vector3f axis_y_W_ = Eigen::Vector3f::UnitY();
  Eigen::Vector3f normal_W_ = Eigen::Vector3f::UnitZ();
  float reach_m_ = 0.0F;
  float radius_squared_ = -1.0F;  // of the sphere around all that it covers; negative: nothing
  std::vector<Eigen::Vector2f> loop_;
  Color color_;
};

}  // namespace handgraft::client::render
