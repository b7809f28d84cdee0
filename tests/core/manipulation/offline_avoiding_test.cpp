// All frames at once, out of an object.
#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "core/manipulation/causal_solver.h"
#include "core/manipulation/offline_solver.h"

#include "tests/core/manipulation/motions.h"
#include "tests/support/ball_hand.h"

namespace handgraft::manipulation {
namespace {

using test::distanceOf;
using test::randomPose;
using test::reachableMotion;
using test::smoothPoses;

/// A hand of balls whose contacts want it 10 mm inside a large ball.
class BallsAtABall : public testing::Test {
 protected:
  BallsAtABall() {
    const hand::LinkPoses X_OL = forwardKinematics(*hand.model, pose);
    const Eigen::Vector3d tip = X_OL.back().translation();
    const Eigen::Vector3d out = (tip - X_OL.front().translation()).normalized();
    avoidance->hand =
        std::make_shared<const hand::HandSolid>(*hand.model, *hand.skin, Progress());
    avoidance->object_O = std::make_shared<const geometry::Solid>(
        geometry::transformed(geometry::makeSphere(0.04, 4),
                              Eigen::Affine3d(Eigen::Translation3d(tip + 0.04 * out))),
        Progress());
  }

  double deepest(const std::vector<hand::HandPose>& poses) const {
    double depth = 0.0;
    for (const hand::HandPose& one : poses) {
      const hand::LinkPoses X = forwardKinematics(*hand.model, one);
      for (const hand::LinkSolid& link : avoidance->hand->links())
        for (const hand::SurfaceSample& sample : link.fine.samples)
          depth = std::max(depth, -avoidance->object_O->grid().at(
                                      X[static_cast<std::size_t>(link.link)] * sample.p_L));
    }
    return depth;
  }

  std::mt19937 random{5};
  test::BallHand hand = test::withBalls(*test::syntheticHand(), 0.01);
  hand::HandPose pose = randomPose(*hand.model, random);
  std::shared_ptr<optimize::Avoidance> avoidance = std::make_shared<optimize::Avoidance>();
};

TEST_F(BallsAtABall, StayOut) {
  MotionProblem problem =
      reachableMotion(hand.model, std::vector<hand::HandPose>(8, pose), 120.0, random);
  EXPECT_GT(deepest(solveOffline(problem, {}, Progress()).poses), 5e-3);
  problem.avoidance = avoidance;
  EXPECT_LT(deepest(solveOffline(problem, {}, Progress()).poses), 5e-4);
  EXPECT_LT(deepest(solveCausal(problem, {}, Progress()).poses), 5e-4);
}

// Some frames are searched first, those between them and behind the last one next: none of it
// shows, nor where parts meet.
TEST_F(BallsAtABall, GoAboutItInPartsWithoutASeam) {
  hand::HandPose beside = pose;
  beside.X_WH.translation() += Eigen::Vector3d(0.03, 0.02, -0.01);
  MotionProblem problem =
      reachableMotion(hand.model, smoothPoses(pose, beside, 150), 120.0, random);
  problem.avoidance = avoidance;
  MotionOptions options;
  options.smoothness = 1e4;
  const Trajectory whole = solveOffline(problem, options, Progress());
  options.frames_at_once = 64;
  const Trajectory parts = solveOffline(problem, options, Progress());
  for (const Trajectory* one : {&whole, &parts}) {
    EXPECT_LT(deepest(one->poses), 5e-4);
    double mean = 0.0;
    for (std::size_t k = 1; k < 150; ++k)
      mean += distanceOf(one->poses[k], one->poses[k - 1]) / 149.0;
    for (std::size_t k = 1; k < 150; ++k)
      EXPECT_LT(distanceOf(one->poses[k], one->poses[k - 1]), 4.0 * mean) << k;
  }
  EXPECT_LT(measureSmoothness(problem, parts.poses).rms_jerk,
            1.2 * measureSmoothness(problem, whole.poses).rms_jerk);
}

// Also where 25 frames lie between two of those, and where there are but a few.
TEST_F(BallsAtABall, StayOutAtAnyRate) {
  hand::HandPose beside = pose;
  beside.X_WH.translation() += Eigen::Vector3d(0.01, 0.01, -0.005);
  for (const auto& [frames, rate_hz] : {std::pair(150, 1000.0), {3, 120.0}, {4, 240.0}}) {
    MotionProblem problem =
        reachableMotion(hand.model, smoothPoses(pose, beside, frames), rate_hz, random);
    problem.avoidance = avoidance;
    MotionOptions options;
    options.frames_at_once = 16;
    std::vector<double> told;
    const Progress listened([&](std::string_view, double fraction) {
      told.push_back(fraction);
    });
    const Trajectory answer = solveOffline(problem, options, listened);
    EXPECT_LT(deepest(answer.poses), 5e-4) << rate_hz;
    EXPECT_LT(meanFit(fitFrames(problem, answer.poses)).mean_mm, 25.0) << rate_hz;
    EXPECT_LE(*std::max_element(told.begin(), told.end()), 1.0);
  }
}

}  // namespace
}  // namespace handgraft::manipulation
