#pragma once

#include <vector>

#include <Eigen/Core>

namespace handgraft::client::render {

enum class Projection { kPerspective, kOrthographic };

/// A place on the screen: pixels from the top left, and a depth key that is linear in them.
struct ScreenPoint {
  float x = 0.0F;
  float y = 0.0F;
  float nearness = 0.0F;  ///< larger is nearer: 1/z (perspective) or -z (orthographic)
};

/// Looks at a scene. Frame C: x right, y down, z away from the viewer; metres.
class Camera {
 public:
  /// A camera that shows all of `points_W`, which it looks at along `-from_W`, as large as a
  /// picture of `width` x `height` pixels allows with a margin of 4 %.
  ///
  /// `up_W` is shown upwards; when it is parallel to `from_W` another one is taken. Points that
  /// are not finite do not count; without any, the camera shows a cube of 0.2 m at the origin.
  /// Errors: InvalidInput if `from_W` is zero or not finite.
  static Camera fitting(const std::vector<Eigen::Vector3f>& points_W,
                        const Eigen::Vector3d& from_W,
                        const Eigen::Vector3d& up_W,
                        int width,
                        int height,
                        Projection projection);

  [[nodiscard]] Eigen::Vector3f toCamera(const Eigen::Vector3f& p_W) const {
    return R_CW_ * p_W + p_CW_;
  }

  /// Requires p_C.z() >= nearPlane().
  [[nodiscard]] ScreenPoint toScreen(const Eigen::Vector3f& p_C) const {
    if (projection_ == Projection::kOrthographic) {
      return {center_x_ + scale_ * p_C.x(), center_y_ + scale_ * p_C.y(), -p_C.z()};
    }
    const float inverse = 1.0F / p_C.z();
    return {center_x_ + scale_ * p_C.x() * inverse, center_y_ + scale_ * p_C.y() * inverse,
            inverse};
  }

  /// Where a point falls, in samples of which a pixel has `factor` a side. What is nearer than
  /// the near plane counts as on it, so that rounding does no harm.
  [[nodiscard]] ScreenPoint toSample(const Eigen::Vector3f& p_W, float factor) const;

  /// Distance in front of the eye where the visible world begins, m.
  [[nodiscard]] float nearPlane() const { return near_; }

  [[nodiscard]] Projection projection() const { return projection_; }

  /// Unit vector from a point to the eye.
  [[nodiscard]] Eigen::Vector3f towardsEye(const Eigen::Vector3f& p_W) const;

  /// Unit vectors of the picture: right and up.
  [[nodiscard]] Eigen::Vector3f right() const { return R_CW_.row(0).transpose(); }

  [[nodiscard]] Eigen::Vector3f up() const { return -R_CW_.row(1).transpose(); }

  [[nodiscard]] Eigen::Vector3f forward() const { return R_CW_.row(2).transpose(); }

 private:
  Projection projection_ = Projection::kPerspective;
  Eigen::Matrix3f R_CW_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f p_CW_ = Eigen::Vector3f::Zero();
  float scale_ = 1.0F;  // pixels per unit slope, or per metre
  float center_x_ = 0.0F;
  float center_y_ = 0.0F;
  float near_ = 0.0F;
};

}  // namespace handgraft::client::render
