#include "client/present/render/decal_area.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace handgraft::client::render {

namespace {

constexpr float kLeastCosine = 0.34F;  // 70 degrees

}  // namespace

DecalArea::DecalArea(const Decal& decal) : reach_m_(decal.reach_m), color_(decal.color) {
  const std::size_t count = decal.loop_W.size();
  if (count < 3) return;
  for (const Eigen::Vector3f& p_W : decal.loop_W) {
    if (!p_W.allFinite()) return;
    center_W_ += p_W / static_cast<float>(count);
  }
  // Newell's normal: the area vector of the loop, also when it is not plane.
  Eigen::Vector3f area = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    area += (decal.loop_W[i] - center_W_).cross(decal.loop_W[(i + 1) % count] - center_W_);
  }
  if (!(area.norm() > 0.0F)) return;
  normal_W_ = area.normalized();
  axis_x_W_ = normal_W_.unitOrthogonal();
  axis_y_W_ = normal_W_.cross(axis_x_W_);
  float widest = 0.0F;
  for (const Eigen::Vector3f& p_W : decal.loop_W) {
    const Eigen::Vector3f d = p_W - center_W_;
    loop_.emplace_back(axis_x_W_.dot(d), axis_y_W_.dot(d));
    widest = std::max(widest, loop_.back().squaredNorm());
    // A loop that bends around the object reaches out of its own mean plane.
    reach_m_ = std::max(reach_m_, std::abs(normal_W_.dot(d)) + 0.25F * decal.reach_m);
  }
  radius_squared_ = widest + reach_m_ * reach_m_;
}

bool DecalArea::covers(const Eigen::Vector3f& p_W, const Eigen::Vector3f& n_W) const {
  const Eigen::Vector3f d = p_W - center_W_;
  if (!(d.squaredNorm() <= radius_squared_) || std::abs(normal_W_.dot(d)) > reach_m_ ||
      std::abs(normal_W_.dot(n_W)) < kLeastCosine) {
    return false;
  }
  // Inside a polygon: a ray to the right crosses its sides an odd number of times.
  const Eigen::Vector2f q(axis_x_W_.dot(d), axis_y_W_.dot(d));
  bool inside = false;
  for (std::size_t i = 0, j = loop_.size() - 1; i < loop_.size(); j = i++) {
    const Eigen::Vector2f& a = loop_[i];
    const Eigen::Vector2f& b = loop_[j];
    if ((a.y() > q.y()) != (b.y() > q.y()) &&
        q.x() < a.x() + (b.x() - a.x()) * (q.y() - a.y()) / (b.y() - a.y())) {
      inside = !inside;
    }
  }
  return inside;
}

}  // namespace handgraft::client::render
