#include "core/placement/hand_pose_guess.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::placement {
namespace {

using test::BallGrasp;

std::vector<Anchor> anchorsOf(const BallGrasp& grasp, bool with_directions) {
  std::vector<Anchor> anchors;
  for (std::size_t i = 0; i < grasp.contacts.patches.size(); ++i) {
    Anchor anchor = *anchorAt(
        *grasp.small.skin,
        transfer::placementAt(*grasp.small.model, *grasp.small.skin, grasp.small.sites[i]));
    anchor.p_O = positionOf(*grasp.ball, grasp.contacts.patches[i].root);
    anchor.n_O = normalOf(*grasp.ball, grasp.contacts.patches[i].root);
    if (with_directions) anchor.direction_O = -Eigen::Vector3d::UnitZ();
    anchors.push_back(anchor);
  }
  return anchors;
}

TEST(HandPoseGuesser, BringsTheRootsTogetherFromOutside) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin, grasp.ball);
  const auto anchors = anchorsOf(grasp, false);
  Pose X_WO = Pose::Identity();
  X_WO.linear() = rotationFromVector({1, 2, 0.5});
  X_WO.translation() << 0.5, 0.2, -0.7;
  const auto placements = placer.place(anchors, X_WO, 12, Progress());
  ASSERT_EQ(placements.size(), 12u);
  const hand::HandPose& best = placements.front().pose;
  EXPECT_LT(std::sqrt(placer.meanSquareDepth(best, X_WO)), 0.002);
  const hand::LinkPoses X_WL = forwardKinematics(*grasp.small.model, best);
  for (const Anchor& anchor : anchors) {
    EXPECT_LT((X_WL[anchor.link] * anchor.p_L - X_WO * anchor.p_O).norm(), 0.006);
    const Eigen::Vector3d n_W = X_WL[anchor.link].linear() * anchor.n_L;
    EXPECT_LT(n_W.dot(X_WO.linear() * anchor.n_O), -0.7);
  }
}

TEST(HandPoseGuesser, OrdersByScore) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin, grasp.ball);
  const auto placements = placer.place(anchorsOf(grasp, true), Pose::Identity(), 6, Progress());
  for (std::size_t i = 1; i < placements.size(); ++i) {
    EXPECT_LE(placements[i - 1].score, placements[i].score);
  }
}

TEST(HandPoseGuesser, MeasuresDepthInsideTheObject) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin, grasp.ball);
  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd::Zero(6)};
  Pose far = Pose::Identity();
  far.translation().x() = 1.0;
  EXPECT_EQ(placer.meanSquareDepth(pose, far), 0.0);
  Pose at_tip = Pose::Identity();  // the thumb's tip of 10 mm in the middle of a ball of 30 mm
  at_tip.translation() << -0.04, 0.0, 0.06;
  EXPECT_GT(placer.meanSquareDepth(pose, at_tip), 0.01 * 0.02 * 0.02);
}

TEST(HandPoseGuesser, StopsWhenAsked) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin, grasp.ball);
  Progress progress;
  progress.cancel();
  EXPECT_THROW((void)placer.place(anchorsOf(grasp, true), Pose::Identity(), 6, progress),
               Cancelled);
}

}  // namespace
}  // namespace handgraft::placement
