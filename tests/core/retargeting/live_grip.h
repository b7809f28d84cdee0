#pragma once

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "core/base/pose.h"
#include "core/hand/mano_joints.h"
#include "core/retargeting/live_follower.h"
#include "core/session/session.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::test {

/// A hand whose fingers, more and more bent, have the ball between them and the palm.
inline manipulation::DemonstratedFrame grip(double time_s,
                                            double bend_rad,
                                            double away_m = 0.0) {
  Eigen::Matrix<double, hand::kManoPoseSize, 1> pose;
  pose.setZero();
  for (int joint = 0; joint < 12; ++joint)
    pose[3 + 3 * joint + 2] = bend_rad;
  manipulation::DemonstratedFrame frame;
  frame.time_s = time_s;
  frame.joints_W = hand::manoJointPlaces(pose, Eigen::Vector3d::Zero(), hand::HandSide::kRight);
  // The ball's middle lies before the knuckles, below the palm.
  frame.X_WO.translation() = Eigen::Vector3d(-0.01, -0.045 - away_m, -0.01);
  return frame;
}

inline double meanDistance(const retargeting::LiveFollower::Answer& answer) {
  double sum_mm = 0.0;
  for (const retargeting::LiveFollower::PartFit& fit : answer.parts)
    sum_mm += fit.distance_mm;
  return sum_mm / static_cast<double>(std::max<std::size_t>(1, answer.parts.size()));
}

class LiveFollowing : public testing::Test {
 protected:
  LiveFollowing() : session(grasp.open()) {}

  std::unique_ptr<retargeting::LiveFollower> follower() {
    return std::make_unique<retargeting::LiveFollower>(session.document(), grasp.hand(),
                                                       grasp.ball, Progress());
  }

  /// Another hand at the same ball.
  std::unique_ptr<retargeting::LiveFollower> followerOf(const hand::Hand& hand) {
    const session::Session opened(hand, grasp.ball, grasp.contacts, Pose::Identity(), {});
    return std::make_unique<retargeting::LiveFollower>(opened.document(), hand, grasp.ball,
                                                       Progress());
  }

  BallGrasp grasp;
  session::Session session;
};

}  // namespace handgraft::test
