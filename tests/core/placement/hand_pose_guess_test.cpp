#include "core/placement/hand_pose_guess.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/placement/solids.h"

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
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin,
                               solidOf(grasp.ball, Progress()));
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
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin,
                               solidOf(grasp.ball, Progress()));
  const auto placements = placer.place(anchorsOf(grasp, true), Pose::Identity(), 6, Progress());
  for (std::size_t i = 1; i < placements.size(); ++i) {
    EXPECT_LE(placements[i - 1].score, placements[i].score);
  }
}

TEST(HandPoseGuesser, MeasuresDepthInsideTheObject) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin,
                               solidOf(grasp.ball, Progress()));
  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd::Zero(6)};
  Pose far = Pose::Identity();
  far.translation().x() = 1.0;
  EXPECT_EQ(placer.meanSquareDepth(pose, far), 0.0);
  Pose at_tip = Pose::Identity();  // the thumb's tip of 10 mm in the middle of a ball of 30 mm
  at_tip.translation() << -0.04, 0.0, 0.06;
  EXPECT_GT(placer.meanSquareDepth(pose, at_tip), 0.01 * 0.02 * 0.02);
}

/// A box of thin faces about the origin, its lid at +z; faces turn outwards.
std::shared_ptr<const geometry::TriangleMesh> boxOfSheets(double half, bool has_lid) {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i)
    corners.col(i) =
        half * Eigen::Vector3d((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1);
  Eigen::Matrix3Xi faces(3, 12);
  faces << 0, 0, 0, 0, 2, 2, 1, 1, 0, 0, 4, 4,  //
      3, 2, 5, 1, 7, 3, 7, 5, 6, 4, 5, 7,       //
      1, 3, 4, 5, 6, 7, 3, 7, 2, 6, 7, 6;
  return std::make_shared<const geometry::TriangleMesh>(
      corners, has_lid ? faces : Eigen::Matrix3Xi(faces.leftCols(10)));
}

TEST(HandPoseGuesser, AHandInAnOpenBoxIsInsideOfNothing) {
  const BallGrasp grasp;
  const auto depth_in = [&](bool has_lid) {
    const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin,
                                 solidOf(boxOfSheets(0.2, has_lid), Progress()));
    return placer.meanSquareDepth({Pose::Identity(), Eigen::VectorXd::Zero(6)},
                                  Pose::Identity());
  };
  EXPECT_GT(depth_in(true), 0.05 * 0.05);
  EXPECT_EQ(depth_in(false), 0.0);
}

TEST(HandPoseGuesser, StopsWhenAsked) {
  const BallGrasp grasp;
  const HandPoseGuesser placer(grasp.small.model, *grasp.small.skin,
                               solidOf(grasp.ball, Progress()));
  Progress progress;
  progress.cancel();
  EXPECT_THROW((void)placer.place(anchorsOf(grasp, true), Pose::Identity(), 6, progress),
               Cancelled);
}

}  // namespace
}  // namespace handgraft::placement
