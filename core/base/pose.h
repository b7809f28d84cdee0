#pragma once

#include <Eigen/Geometry>

namespace handgraft {

/// Rigid motion X_AB: p_A = X_AB * p_B. Frames are letters: W world, O object, H hand root,
/// L link, S skin (reference pose), T tangent plane. Metres and radians.
using Pose = Eigen::Isometry3d;

/// Rotation by the vector `w` (axis times angle, rad). Exact at zero.
Eigen::Matrix3d rotationFromVector(const Eigen::Vector3d& w);

/// The rotation vector of R, its angle in [0, pi]; the axis' sign at pi is the one whose first
/// non-zero coordinate is positive. Accurate at both ends of the range.
Eigen::Vector3d vectorFromRotation(const Eigen::Matrix3d& R);

/// Skew matrix: crossMatrix(a) * b = a x b.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& a);

/// Left Jacobian of SO(3) at w: exp(w + dw) = exp(J dw) exp(w) to first order.
Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& w);

/// Inverse of `leftJacobian`; defined for |w| < 2 pi.
Eigen::Matrix3d leftJacobianInverse(const Eigen::Vector3d& w);

/// Pose from a quaternion and a position. Throws InvalidInput unless all are finite and the
/// quaternion's norm lies within 1e-3 of 1; normalises it. `name` appears in the message.
Pose poseFromQuaternion(const Eigen::Vector3d& p_m,
                        const Eigen::Vector4d& q_wxyz,
                        const char* name);

/// Quaternion w, x, y, z of a pose, with w >= 0.
Eigen::Vector4d quaternionOf(const Pose& X);

/// X^-1 with the rotation transposed; `Pose::inverse()` spelled for rigid motions.
inline Pose inverse(const Pose& X) {
  return X.inverse(Eigen::Isometry);
}

}  // namespace handgraft
