#include "core/base/pose.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace handgraft {

namespace {

// Below this angle the closed forms lose digits to cancellation and the series are exact.
constexpr double kSmallAngle = 1e-4;

}  // namespace

Eigen::Matrix3d rotationFromVector(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d W = crossMatrix(w);
  double a = 1.0 - angle * angle / 6.0;   // sin(x)/x
  double b = 0.5 - angle * angle / 24.0;  // (1-cos(x))/x^2
  if (angle > kSmallAngle) {
    const double half_sine = std::sin(0.5 * angle);
    a = std::sin(angle) / angle;
    b = 2.0 * half_sine * half_sine / (angle * angle);
  }
  return Eigen::Matrix3d::Identity() + a * W + b * W * W;
}

Eigen::Vector3d vectorFromRotation(const Eigen::Matrix3d& R) {
  // The quaternion is well conditioned for every angle; atan2 keeps digits near 0 and pi.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * q.vec();
  const double angle = 2.0 * std::atan2(sine, q.w());
  Eigen::Vector3d axis = q.vec() / sine;
  if (angle > std::numbers::pi - 1e-12) {
    for (int i = 0; i < 3; ++i) {
      if (std::abs(axis[i]) < 1e-9) continue;
      if (axis[i] < 0.0) axis = -axis;
      break;
    }
  }
  return angle * axis;
}

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d W = crossMatrix(w);
  double b = 0.5 - angle * angle / 24.0;         // (1-cos(x))/x^2
  double c = 1.0 / 6.0 - angle * angle / 120.0;  // (x-sin(x))/x^3
  if (angle > kSmallAngle) {
    const double half_sine = std::sin(0.5 * angle);
    b = 2.0 * half_sine * half_sine / (angle * angle);
    // The difference x - sin(x) cancels below about 1e-2: the series is exact there.
    c = angle < 1e-2 ? 1.0 / 6.0 - angle * angle / 120.0 + std::pow(angle, 4) / 5040.0
                     : (angle - std::sin(angle)) / (angle * angle * angle);
  }
  return Eigen::Matrix3d::Identity() + b * W + c * W * W;
}

Eigen::Matrix3d leftJacobianInverse(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d W = crossMatrix(w);
  // 1/x^2 - (1+cos x)/(2 x sin x) = (1 - (x/2) cot(x/2)) / x^2
  double d = 1.0 / 12.0 + angle * angle / 720.0;
  if (angle > 1e-2) {
    const double half = 0.5 * angle;
    d = (1.0 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  }
  return Eigen::Matrix3d::Identity() - 0.5 * W + d * W * W;
}

Pose poseFromQuaternion(const Eigen::Vector3d& p_m,
                        const Eigen::Vector4d& q_wxyz,
                        const char* name) {
  if (!p_m.allFinite()) {
    rejectInput("{}: position ({}, {}, {}) must be finite, in metres", name, p_m.x(), p_m.y(),
                p_m.z());
  }
  constexpr double kNormTolerance = 1e-3;  // room for quaternions written with four decimals
  const double norm = q_wxyz.norm();
  if (!q_wxyz.allFinite() || std::abs(norm - 1.0) > kNormTolerance) {
    rejectInput(
        "{}: quaternion w x y z = ({}, {}, {}, {}) has norm {:.4g}; it must be 1 "
        "within {}",
        name, q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3], norm, kNormTolerance);
  }
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3])
                   .normalized()
                   .toRotationMatrix();
  X.translation() = p_m;
  return X;
}

Eigen::Vector4d quaternionOf(const Pose& X) {
  Eigen::Quaterniond q(X.linear());
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return {q.w(), q.x(), q.y(), q.z()};
}

}  // namespace handgraft
