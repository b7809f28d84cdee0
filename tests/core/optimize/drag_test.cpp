// Drags against what a drawing says: planar arms in closed form, and hands that should keep
// their other fingers where they are.
#include "core/optimize/drag.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/small_hand.h"

namespace handgraft::optimize {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kUpper = 0.3;  // m; of the arm's links
constexpr double kFore = 0.2;   // m

/// Two links in the plane z = 0, joints about z, the root's six freedoms locked.
PoseProblem planarArm(double lower = -kPi, double upper = kPi) {
  std::vector<hand::Link> links(3);
  links[0].name = "base";
  links[1].name = "upper";
  links[2].name = "fore";
  std::vector<hand::Joint> joints(2);
  for (int i = 0; i < 2; ++i) {
    joints[i].name = i == 0 ? "shoulder" : "elbow";
    joints[i].type = hand::JointType::kRevolute;
    joints[i].parent_link = links[i].name;
    joints[i].child_link = links[i + 1].name;
    joints[i].axis_J = Eigen::Vector3d::UnitZ();
    joints[i].lower = lower;
    joints[i].upper = upper;
  }
  joints[1].X_PJ.translation().x() = kUpper;
  PoseProblem problem =
      makeProblem(std::make_shared<const hand::HandModel>("arm", links, joints));
  problem.start.q << 0.4, 0.8;
  problem.locked.assign(8, false);
  std::fill_n(problem.locked.begin(), 6, true);
  return problem;
}

DragTarget tipTo(const Eigen::Vector3d& target_W) {
  DragTarget target;
  target.link = 2;
  target.p_L = kFore * Eigen::Vector3d::UnitX();
  target.target_W = target_W;
  return target;
}

Eigen::Vector3d pointOf(const PoseProblem& problem,
                        const DragResult& result,
                        const DragTarget& target) {
  return forwardKinematics(*problem.model, result.pose)[static_cast<std::size_t>(target.link)] *
         target.p_L;
}

TEST(Drag, OfAPlanarArmIsTheLawOfCosines) {
  const PoseProblem problem = planarArm();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radius(0.12, 0.48);
  std::uniform_real_distribution<double> angle(-1.2, 2.0);
  for (int i = 0; i < 50; ++i) {
    const double r = radius(random);
    const double phi = angle(random);
    const DragTarget target = tipTo({r * std::cos(phi), r * std::sin(phi), 0});
    const DragResult result = drag(problem, target);
    EXPECT_LT((pointOf(problem, result, target) - target.target_W).norm(), 1e-4);
    EXPECT_LT(result.short_m, 1e-4);
    const double elbow =
        std::acos((r * r - kUpper * kUpper - kFore * kFore) / (2.0 * kUpper * kFore));
    EXPECT_NEAR(std::abs(std::remainder(result.pose.q[1], 2.0 * kPi)), elbow, 2e-3);
    EXPECT_FALSE(result.root_moved);
  }
}

TEST(Drag, OutOfReachStretchesTowardsTheTargetAndSaysHowShortItIs) {
  const PoseProblem problem = planarArm();
  const DragTarget target = tipTo({0.6, 0.8, 0});  // 1 m away, the arm is 0.5 m long
  const DragResult result = drag(problem, target);
  EXPECT_NEAR(result.short_m, 0.5, 1e-4);
  EXPECT_NEAR(result.pose.q[0], std::atan2(0.8, 0.6), 1e-2);
  EXPECT_NEAR(result.pose.q[1], 0.0, 2e-2);
}

TEST(Drag, OffThePlaneEndsAtTheNearestPoint) {
  const PoseProblem problem = planarArm();
  const DragResult result = drag(problem, tipTo({0.3, 0.2, 0.07}));
  EXPECT_NEAR(result.short_m, 0.07, 1e-4);
}

TEST(Drag, KeepsLimitsAndLocks) {
  PoseProblem problem = planarArm(0.1, 1.0);
  problem.start.q << 0.5, 0.5;
  const DragResult limited = drag(problem, tipTo({-0.3, -0.1, 0}));
  EXPECT_GT(limited.short_m, 0.1);
  for (const double q : limited.pose.q) {
    EXPECT_GE(q, 0.1);
    EXPECT_LE(q, 1.0);
  }
  problem.locked[6] = true;
  const DragResult locked = drag(problem, tipTo({0.1, 0.4, 0}));
  EXPECT_EQ(locked.pose.q[0], 0.5);
  EXPECT_EQ(locked.pose.X_WH.matrix(), problem.start.X_WH.matrix());
}

TEST(Drag, MovesTheFingerAloneWhileThatIsEnough) {
  const test::SmallHand small = test::makeSmallHand();
  const PoseProblem problem = makeProblem(small.model);
  const int tip = small.model->linkIndex("index_tip");
  DragTarget target;
  target.link = tip;
  target.p_L = {0, 0, 0.02};
  Eigen::VectorXd bent = problem.start.q;
  bent[2] = 0.5;
  bent[3] = 0.7;
  target.target_W =
      forwardKinematics(*small.model,
                        hand::HandPose{Pose::Identity(), bent})[static_cast<std::size_t>(tip)] *
      target.p_L;
  const DragResult result = drag(problem, target);
  EXPECT_LT(result.short_m, 1e-4);
  EXPECT_FALSE(result.root_moved);
  EXPECT_EQ(result.pose.X_WH.matrix(), problem.start.X_WH.matrix());
  for (const int other : {0, 1, 4, 5})
    EXPECT_EQ(result.pose.q[other], problem.start.q[other]);
}

TEST(Drag, TakesThePalmAlongWhereTheFingerIsTooShortAndNoFartherThanItMay) {
  const test::SmallHand small = test::makeSmallHand();
  const PoseProblem problem = makeProblem(small.model);
  DragTarget target;
  target.link = small.model->linkIndex("index_tip");
  target.p_L = {0, 0, 0.02};
  target.target_W = {0.04, 0.035, 0.07};  // 2 cm across the finger's plane
  const DragResult near = drag(problem, target);
  EXPECT_LT(near.short_m, 1e-4);
  EXPECT_TRUE(near.root_moved);

  target.target_W = {0.04, 0.5, 0.07};
  const DragResult far = drag(problem, target);
  EXPECT_GT(far.short_m, 0.2);
  EXPECT_LE(far.pose.X_WH.translation().cwiseAbs().maxCoeff(), 0.05 + 1e-12);
  EXPECT_LE(vectorFromRotation(far.pose.X_WH.linear()).norm(), 0.5 + 1e-9);
}

TEST(Drag, OfThePalmLeavesTheFingertipsWhereTheyAre) {
  const test::SmallHand small = test::makeSmallHand();
  PoseProblem problem = makeProblem(small.model);
  problem.start.q.setConstant(0.5);
  const hand::LinkPoses before = forwardKinematics(*small.model, problem.start);
  int patch = 0;
  for (const hand::ContactSite& site : small.sites) {
    PointPair pair;
    pair.link = small.model->linkIndex(site.link);
    pair.p_L = site.p_L;
    pair.n_L = site.n_L;
    pair.p_W = Eigen::Vector3d::Zero();  // where the object is plays no part
    pair.n_W = Eigen::Vector3d::UnitX();
    pair.patch = patch++;
    problem.pairs.push_back(pair);
  }
  DragTarget target;
  target.link = 0;
  target.target_W = {0, 0, -0.006};
  const DragResult result = drag(problem, target);
  EXPECT_LT(result.short_m, 1e-4);
  const hand::LinkPoses after = forwardKinematics(*small.model, result.pose);
  for (const PointPair& pair : problem.pairs) {
    const auto link = static_cast<std::size_t>(pair.link);
    // Had the joints stayed, every tip would have gone 6 mm along.
    EXPECT_LT((after[link] * pair.p_L - before[link] * pair.p_L).norm(), 0.002);
  }
}

TEST(Drag, TurnsAFrame) {
  const test::SmallHand small = test::makeSmallHand();
  const PoseProblem problem = makeProblem(small.model);
  DragTarget target;
  target.link = 0;
  target.target_W = {0.1, -0.2, 0.3};
  target.R_WL = rotationFromVector({0.3, -0.5, 1.1});
  const DragResult result = drag(problem, target);
  EXPECT_LT(result.short_m, 1e-4);
  EXPECT_LT(result.short_rad, 1e-3);
  EXPECT_TRUE(result.pose.X_WH.linear().isApprox(*target.R_WL, 1e-3));
}

TEST(Drag, ToWhereThePointIsMovesNothing) {
  const test::SmallHand small = test::makeSmallHand();
  PoseProblem problem = makeProblem(small.model);
  problem.start.q.setConstant(0.4);
  DragTarget target;
  target.link = small.model->linkIndex("thumb_tip");
  target.p_L = {0, 0, 0.02};
  target.target_W =
      forwardKinematics(*small.model, problem.start)[static_cast<std::size_t>(target.link)] *
      target.p_L;
  const DragResult result = drag(problem, target);
  EXPECT_LT((result.pose.q - problem.start.q).norm(), 1e-9);
}

TEST(Drag, GivesTheSameBytesAgain) {
  const test::SmallHand small = test::makeSmallHand();
  const PoseProblem problem = makeProblem(small.model);
  DragTarget target;
  target.link = small.model->linkIndex("middle_tip");
  target.p_L = {0, 0, 0.03};
  target.target_W = {0.01, 0.03, 0.06};
  const DragResult a = drag(problem, target);
  const DragResult b = drag(problem, target);
  EXPECT_EQ(a.pose.q, b.pose.q);
  EXPECT_EQ(a.pose.X_WH.matrix(), b.pose.X_WH.matrix());
}

TEST(Drag, RefusesTargetsThatAreNowhere) {
  const PoseProblem problem = planarArm();
  const auto refuses = [&](double x, const char* text) {
    EXPECT_THAT(
        [&] {
          (void)drag(problem, tipTo({x, 0, 0}));
        },
        ThrowsMessage<InvalidInput>(HasSubstr(text)));
  };
  refuses(std::numeric_limits<double>::quiet_NaN(), "finite");
  refuses(std::numeric_limits<double>::infinity(), "finite");
  refuses(11.0, "11 m from the origin");
}

}  // namespace
}  // namespace handgraft::optimize
