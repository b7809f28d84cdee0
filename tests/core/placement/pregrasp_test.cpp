#include "core/placement/pregrasp.h"

#include <gtest/gtest.h>

#include "core/placement/solids.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::placement {
namespace {

using test::BallGrasp;

/// The small hand's grasp of a ball, and the same hand with other rest poses and limits.
struct Grasped {
  BallGrasp grasp;
  session::Solution solution = grasp.open().solve({}, session::SolveRun(), Progress());

  [[nodiscard]] hand::Hand restingAt(const Eigen::VectorXd& q) const {
    hand::Hand hand = grasp.hand();
    hand.model = std::make_shared<const hand::HandModel>(hand.model->withRestPose(q));
    return hand;
  }

  [[nodiscard]] Pregrasp pregraspWith(const hand::Hand& hand) const {
    return pregraspOf(hand, grasp.ball, Pose::Identity(), solution.report.pose,
                      solution.problem.pairs, Progress());
  }

  [[nodiscard]] double depthAt(const hand::Hand& hand, const Eigen::VectorXd& q) const {
    return depthsOf(hand.model, hand.skin, grasp.ball, {solution.report.pose.X_WH, q},
                    Progress())
        .object_m;
  }
};

TEST(Pregrasp, IsTheRestPoseWhereThatIsClear) {
  const Grasped grasped;
  const hand::Hand open = grasped.restingAt(Eigen::VectorXd::Constant(6, -0.3));
  ASSERT_LT(grasped.depthAt(open, open.model->restPose()), 5e-4);
  const Pregrasp before = grasped.pregraspWith(open);
  EXPECT_TRUE(before.is_clear);
  EXPECT_EQ(before.q, open.model->restPose());
}

// As of a gripper, which rests closed.
TEST(Pregrasp, OpensTheFingersWhereTheRestPoseIsInTheObject) {
  const Grasped grasped;
  const hand::Hand closed =
      grasped.restingAt((grasped.solution.report.pose.q.array() + 0.35).matrix());
  ASSERT_GT(grasped.depthAt(closed, closed.model->restPose()), 5e-3);
  const Pregrasp before = grasped.pregraspWith(closed);
  EXPECT_TRUE(before.is_clear);
  EXPECT_LT(grasped.depthAt(closed, before.q), 5e-4);
  EXPECT_GT((before.q - grasped.solution.report.pose.q).norm(), 0.2) << "it has not opened";
  for (const int base : {0, 2, 4})
    EXPECT_LT(before.q[base], grasped.solution.report.pose.q[base]) << base;
}

TEST(Pregrasp, SaysThatNoneIsClear) {
  const Grasped grasped;
  hand::Hand stuck = grasped.restingAt(Eigen::VectorXd::Constant(6, 1.2));
  // The ball about the whole hand.
  const auto cave =
      std::make_shared<const geometry::TriangleMesh>(geometry::makeSphere(0.4, 3));
  const Pregrasp before =
      pregraspOf(stuck, cave, Pose::Identity(), grasped.solution.report.pose,
                 grasped.solution.problem.pairs, Progress());
  EXPECT_FALSE(before.is_clear);
  EXPECT_GT(before.depth_m, 0.05);
}

}  // namespace
}  // namespace handgraft::placement
