#include "client/present/render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr double kFieldOfView = 24.0 * std::numbers::pi / 180.0;  // of the shorter side: little
                                                                  // distortion, still depth
constexpr double kMargin = 0.04;

struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;

  void add(const Eigen::Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

Eigen::Matrix3d axesLooking(const Eigen::Vector3d& from_W, const Eigen::Vector3d& up_W) {
  if (!from_W.allFinite() || !(from_W.norm() > 0.0)) {
    rejectInput("camera direction ({}, {}, {}): it must be finite and not zero", from_W.x(),
                from_W.y(), from_W.z());
  }
  const Eigen::Vector3d forward = -from_W.normalized();
  Eigen::Vector3d right = forward.cross(up_W);
  if (!right.allFinite() || right.norm() < 1e-6 * up_W.norm() || !(right.norm() > 0.0)) {
    right = forward.unitOrthogonal();
  }
  right.normalize();
  Eigen::Matrix3d R_CW;
  R_CW.row(0) = right;
  R_CW.row(1) = forward.cross(right);  // down
  R_CW.row(2) = forward;
  return R_CW;
}

}  // namespace

Camera Camera::fitting(const std::vector<Eigen::Vector3f>& points_W,
                       const Eigen::Vector3d& from_W,
                       const Eigen::Vector3d& up_W,
                       int width,
                       int height,
                       Projection projection) {
  const Eigen::Matrix3d R_CW = axesLooking(from_W, up_W);
  Bounds bounds;
  for (const Eigen::Vector3f& p_W : points_W) {
    if (p_W.allFinite()) bounds.add(R_CW * p_W.cast<double>());
  }
  const bool empty = !bounds.low.allFinite();
  if (empty) {
    bounds.add(Eigen::Vector3d::Constant(-0.1));
    bounds.add(Eigen::Vector3d::Constant(0.1));
  }
  const Eigen::Vector3d center = 0.5 * (bounds.low + bounds.high);
  const Eigen::Vector3d half = (0.5 * (bounds.high - bounds.low)).cwiseMax(1e-6);
  const double usable_x = 0.5 * width * (1.0 - 2.0 * kMargin);
  const double usable_y = 0.5 * height * (1.0 - 2.0 * kMargin);

  double scale = std::min(usable_x / half.x(), usable_y / half.y());
  double distance = 2.0 * half.norm();
  if (projection == Projection::kPerspective) {
    // A point fits when |x| <= (distance + z) * usable / scale; the farthest demand decides.
    scale = 0.5 * std::min(width, height) / std::tan(0.5 * kFieldOfView);
    distance = half.z();
    const auto demand = [&](const Eigen::Vector3d& q) {
      distance = std::max({distance, std::abs(q.x()) * scale / usable_x - q.z(),
                           std::abs(q.y()) * scale / usable_y - q.z()});
    };
    for (const Eigen::Vector3f& p_W : points_W) {
      if (p_W.allFinite()) demand(R_CW * p_W.cast<double>() - center);
    }
    if (empty) demand(half);
    distance = std::max(distance, 1.05 * half.z());
  }

  Camera camera;
  camera.projection_ = projection;
  camera.R_CW_ = R_CW.cast<float>();
  camera.p_CW_ = (Eigen::Vector3d(0.0, 0.0, distance) - center).cast<float>();
  camera.scale_ = static_cast<float>(scale);
  camera.center_x_ = 0.5F * static_cast<float>(width);
  camera.center_y_ = 0.5F * static_cast<float>(height);
  camera.near_ = static_cast<float>(1e-3 * distance);
  return camera;
}

ScreenPoint Camera::toSample(const Eigen::Vector3f& p_W, float factor) const {
  Eigen::Vector3f p_C = toCamera(p_W);
  if (projection_ == Projection::kPerspective) p_C.z() = std::max(p_C.z(), near_);
  const ScreenPoint pixel = toScreen(p_C);
  return {pixel.x * factor, pixel.y * factor, pixel.nearness};
}

Eigen::Vector3f Camera::towardsEye(const Eigen::Vector3f& p_W) const {
  if (projection_ == Projection::kOrthographic) return -forward();
  const Eigen::Vector3f eye_W = -R_CW_.transpose() * p_CW_;
  return (eye_W - p_W).normalized();
}

}  // namespace handgraft::client::render
