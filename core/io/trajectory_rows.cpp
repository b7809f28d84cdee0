#include "core/io/trajectory_rows.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/io/posed_grasp.h"

namespace handgraft::io {

namespace {

/// x y z, qw qx qy qz; near `before`'s quaternion of the two that mean the same.
Eigen::Matrix<double, 7, 1> freeJoint(const Pose& X, const Eigen::VectorXd& before) {
  Eigen::Matrix<double, 7, 1> values;
  values.head<3>() = X.translation();
  values.tail<4>() = quaternionOf(X);
  if (before.size() == 7 && values.tail<4>().dot(before.tail<4>()) < 0.0)
    values.tail<4>() *= -1.0;
  return values;
}

/// The names of the joints, and room for that many frames.
TrajectoryRows roomFor(const hand::HandModel& model,
                       const Eigen::VectorXd& q,
                       Eigen::Index frames) {
  TrajectoryRows rows;
  for (const JointValue& joint : jointValues(model, q)) {
    rows.joint_names.push_back(joint.name);
    rows.independent += joint.follows ? 0 : 1;
  }
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  rows.qpos.resize(14 + joints, frames);
  rows.qvel = Eigen::MatrixXd::Zero(12 + joints, frames);
  return rows;
}

void setJoints(const hand::HandModel& model,
               const Eigen::VectorXd& q,
               Eigen::Index frame,
               TrajectoryRows& rows) {
  const std::vector<JointValue> values = jointValues(model, q);
  for (std::size_t i = 0; i < values.size(); ++i)
    rows.qpos(7 + static_cast<Eigen::Index>(i), frame) = values[i].value;
}

/// From one pose to another in that time: linear in W, angular in the frame's own axes.
Eigen::Matrix<double, 6, 1> freeVelocity(const Pose& from, const Pose& to, double time_s) {
  Eigen::Matrix<double, 6, 1> velocity;
  velocity.head<3>() = (to.translation() - from.translation()) / time_s;
  velocity.tail<3>() = vectorFromRotation(from.linear().transpose() * to.linear()) / time_s;
  return velocity;
}

}  // namespace

TrajectoryRows rowsOf(const HandTrajectory& trajectory) {
  const std::vector<TrajectoryFrame>& all = trajectory.frames;
  HANDGRAFT_REQUIRE(!all.empty());
  const auto frames = static_cast<Eigen::Index>(all.size());
  TrajectoryRows rows = roomFor(*trajectory.model, all.front().pose_W.q, frames);
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  Eigen::VectorXd root;
  Eigen::VectorXd object;
  for (Eigen::Index k = 0; k < frames; ++k) {
    const TrajectoryFrame& frame = all[static_cast<std::size_t>(k)];
    rows.time_s.push_back(frame.time_s - all.front().time_s);
    root = freeJoint(frame.pose_W.X_WH, root);
    object = freeJoint(frame.X_WO, object);
    rows.qpos.col(k).head<7>() = root;
    rows.qpos.col(k).tail<7>() = object;
    setJoints(*trajectory.model, frame.pose_W.q, k, rows);
  }
  for (Eigen::Index k = 0; frames > 1 && k < frames; ++k) {
    const Eigen::Index before = std::max<Eigen::Index>(k - 1, 0);
    const Eigen::Index behind = std::min(k + 1, frames - 1);
    const TrajectoryFrame& from = all[static_cast<std::size_t>(before)];
    const TrajectoryFrame& to = all[static_cast<std::size_t>(behind)];
    const double time_s = to.time_s - from.time_s;
    rows.qvel.col(k).head<6>() = freeVelocity(from.pose_W.X_WH, to.pose_W.X_WH, time_s);
    rows.qvel.col(k).tail<6>() = freeVelocity(from.X_WO, to.X_WO, time_s);
    rows.qvel.col(k).segment(6, joints) =
        (rows.qpos.col(behind).segment(7, joints) - rows.qpos.col(before).segment(7, joints)) /
        time_s;
  }
  return rows;
}

TrajectoryRows rowsOf(const PosedGrasp& grasp) {
  TrajectoryRows rows = roomFor(*grasp.model, grasp.pose.q, 1);
  rows.time_s.push_back(0.0);
  rows.qpos.col(0).head<7>() = freeJoint(grasp.pose.X_WH, {});
  rows.qpos.col(0).tail<7>() = freeJoint(grasp.X_WO, {});
  setJoints(*grasp.model, grasp.pose.q, 0, rows);
  return rows;
}

}  // namespace handgraft::io
