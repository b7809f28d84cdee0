#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/base/pose.h"
#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// A whole-hand pose: the root in the world and the independent joints (rad, m).
struct HandPose {
  Pose X_WH = Pose::Identity();
  Eigen::VectorXd q;
};

using LinkPoses = std::vector<Pose>;

/// Pose of every link, in the model's link order.
///
/// Frames: X_AL for X_AH: give X_WH and get world poses, identity and get poses in H.
/// Errors: BrokenContract unless q has dofCount() entries. Cost: O(links), allocates only when
/// `X_AL` grows.
void forwardKinematics(const HandModel& model,
                       const Pose& X_AH,
                       const Eigen::VectorXd& q,
                       LinkPoses& X_AL);

inline LinkPoses forwardKinematics(const HandModel& model, const HandPose& pose) {
  LinkPoses X_WL;
  forwardKinematics(model, pose.X_WH, pose.q, X_WL);
  return X_WL;
}

/// The independent joints that move each link, by link. Cost: O(links x depth).
std::vector<std::vector<int>> dofsMoving(const HandModel& model);

/// Geometric Jacobian of a point fixed to a link, by the dofs (mimic joints by the chain rule).
///
/// Shapes: 6 x dofCount(): rows 0-2 angular velocity of the link, rows 3-5 velocity of the
/// point,
///   both expressed in the frame A of the link poses.
/// Frames: `X_AL` from forwardKinematics; `p_A` the point in A.
/// Cost: O(depth of the link).
Eigen::Matrix<double, 6, Eigen::Dynamic> pointJacobian(const HandModel& model,
                                                       const LinkPoses& X_AL,
                                                       int link,
                                                       const Eigen::Vector3d& p_A);

}  // namespace handgraft::hand
