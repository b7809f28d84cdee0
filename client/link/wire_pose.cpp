#include "client/link/wire_pose.h"

namespace handgraft::client {

Pose poseOf(const v1::Pose& X, const std::string& what) {
  const auto& p = X.p_m();
  const auto& q = X.q_wxyz();
  return poseFromQuaternion({p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, what.c_str());
}

v1::Pose messageOf(const Pose& X) {
  const Eigen::Vector3d p = X.translation();
  const Eigen::Vector4d q = quaternionOf(X);
  v1::Pose pose;
  pose.p_m() = {p[0], p[1], p[2]};
  pose.q_wxyz() = {q[0], q[1], q[2], q[3]};
  return pose;
}

v1::Pose placeOf(const std::array<double, 7>& numbers, const std::string& what) {
  return messageOf(poseFromQuaternion({numbers[0], numbers[1], numbers[2]},
                                      {numbers[3], numbers[4], numbers[5], numbers[6]},
                                      what.c_str()));
}

}  // namespace handgraft::client
