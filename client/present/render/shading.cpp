#include "client/present/render/shading.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace handgraft::client::render {

Lights::Lights(const Camera& camera)
    : camera_(camera),
      key_W_((-camera.forward() + 0.9F * camera.up() - 0.7F * camera.right()).normalized()),
      up_W_(camera.up()) {}

Color Lights::lit(const Color& color,
                  const Eigen::Vector3f& p_W,
                  const Eigen::Vector3f& n_W) const {
  const Eigen::Vector3f to_eye = camera_.towardsEye(p_W);
  Eigen::Vector3f n = n_W;
  if (n.dot(to_eye) < 0.0F) n = -n;
  const float facing = n.dot(to_eye);
  const float key = std::max(0.0F, n.dot(key_W_));
  const float sky = 0.5F + 0.5F * n.dot(up_W_);
  const float diffuse = (0.30F + 0.14F * sky + 0.52F * key + 0.12F * facing) *
                        (0.72F + 0.28F * std::min(1.0F, 2.2F * facing));  // darker outlines
  const float half = std::max(0.0F, n.dot((key_W_ + to_eye).normalized()));
  const float half_8 = half * half * half * half * half * half * half * half;
  const float highlight = 0.10F * half_8 * half_8 * half_8;
  const auto channel = [&](std::uint8_t value) {
    const float out = static_cast<float>(value) * diffuse + 255.0F * highlight;
    return static_cast<std::uint8_t>(std::clamp(out, 0.0F, 255.0F));
  };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

}  // namespace handgraft::client::render
