#include "core/manipulation/causal_solver.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/optimize/solver.h"

#include "tests/core/manipulation/motions.h"

namespace handgraft::manipulation {
namespace {

using test::randomPose;
using test::reachableMotion;
using test::smoothPoses;

struct Scene {
  std::shared_ptr<const hand::HandModel> model = test::syntheticHand();
  std::mt19937 random{7};
  hand::HandPose from = randomPose(*model, random);
  hand::HandPose to = randomPose(*model, random);
};

double distanceOf(const hand::HandPose& a, const hand::HandPose& b) {
  return (a.X_WH.translation() - b.X_WH.translation()).norm() +
         vectorFromRotation(a.X_WH.linear() * b.X_WH.linear().transpose()).norm() +
         (a.q - b.q).norm();
}

TEST(CausalSolver, StaysAtTheSingleFramesAnswerWhereNothingMoves) {
  Scene scene;
  MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(12, scene.from), 120.0, scene.random);
  // Contacts that do not fit, so that the answer is a compromise.
  for (PairSpan& span : problem.tracks[0].spans)
    for (std::size_t i = 0; i < span.pairs.size(); ++i)
      span.pairs[i].p_W.x() += 0.004 * static_cast<double>(i % 3);
  const Trajectory trajectory = solveCausal(problem, {}, Progress());
  const FrameProblems frames(problem, Fade{});
  const hand::HandPose alone = solveSingle(problem, frames, 0, scene.from, {}, Progress()).pose;
  for (const hand::HandPose& pose : trajectory.poses)
    EXPECT_LT(distanceOf(pose, alone), 2e-3);
}

TEST(CausalSolver, FollowsASmoothMotion) {
  Scene scene;
  const auto truth = smoothPoses(scene.from, scene.to, 240);
  const MotionProblem problem = reachableMotion(scene.model, truth, 120.0, scene.random);
  MotionOptions options;
  options.smoothness = 0.01;
  const Trajectory trajectory = solveCausal(problem, options, Progress());
  for (std::size_t k = 0; k < truth.size(); ++k)
    EXPECT_LT(distanceOf(trajectory.poses[k], truth[k]), 0.05) << k;
}

TEST(CausalSolver, KeepsAllLimits) {
  Scene scene;
  const auto truth = smoothPoses(scene.from, scene.to, 60);
  MotionProblem problem = reachableMotion(scene.model, truth, 120.0, scene.random);
  problem.velocity_limit.setConstant(1.5);
  problem.acceleration_limit.setConstant(20.0);
  MotionOptions options;
  options.smoothness = 0.1;
  const Trajectory trajectory = solveCausal(problem, options, Progress());
  const Smoothness smoothness = measureSmoothness(problem, trajectory.poses);
  EXPECT_LE(smoothness.velocity_share, 1.0 + 1e-9);
  EXPECT_LE(smoothness.acceleration_share, 1.0 + 1e-6);
  EXPECT_GT(smoothness.velocity_share, 0.9) << "the test does not meet the limit";
  for (const hand::HandPose& pose : trajectory.poses) {
    EXPECT_TRUE((pose.q.array() >= problem.lower.array()).all());
    EXPECT_TRUE((pose.q.array() <= problem.upper.array()).all());
  }
}

TEST(CausalSolver, AnswersTheSameBytesTwice) {
  Scene scene;
  const auto truth = smoothPoses(scene.from, scene.to, 40);
  const MotionProblem problem = reachableMotion(scene.model, truth, 60.0, scene.random);
  const Trajectory one = solveCausal(problem, {}, Progress());
  const Trajectory two = solveCausal(problem, {}, Progress());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(one.poses[k].q, two.poses[k].q);
    EXPECT_EQ(one.poses[k].X_WH.matrix(), two.poses[k].X_WH.matrix());
  }
}

TEST(CausalSolver, RefusesTimeThatDoesNotRise) {
  Scene scene;
  const MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(3, scene.from), 120.0, scene.random);
  const FrameProblems frames(problem, Fade{});
  CausalSolver solver(problem, {});
  solver.begin(scene.from);
  static_cast<void>(solver.follow(0.0, frames.at(0, scene.from)));
  static_cast<void>(solver.follow(0.1, frames.at(1, scene.from)));
  EXPECT_THROW(static_cast<void>(solver.follow(0.1, frames.at(2, scene.from))), InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.follow(std::numeric_limits<double>::quiet_NaN(),
                                               frames.at(2, scene.from))),
               InvalidInput);
  // Nothing is lost: it goes on from where it was.
  EXPECT_LT(distanceOf(solver.follow(0.11, frames.at(2, scene.from)).pose, scene.from), 1e-2);
}

TEST(CausalSolver, HoldsStillWithoutContacts) {
  Scene scene;
  MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(30, scene.from), 120.0, scene.random);
  problem.tracks[0].end = 10;
  problem.tracks[0].spans.resize(10);
  MotionOptions options;
  options.fade.seconds = 0.0;
  const Trajectory trajectory = solveCausal(problem, options, Progress());
  EXPECT_LT(distanceOf(trajectory.poses[29], trajectory.poses[9]), 5e-3);
  problem.tracks.clear();
  for (const hand::HandPose& pose : solveCausal(problem, options, Progress()).poses)
    EXPECT_TRUE(pose.q.allFinite());
}

TEST(Presence, FadesAboutAChangeAndNotAtTheEnds) {
  Scene scene;
  MotionProblem problem = makeMotionProblem(scene.model, test::framesAt(100.0, 100));
  PairTrack track;
  track.spans = {{20, {}}};
  track.end = 100;
  Fade fade{0.1, true};
  EXPECT_EQ(presenceAt(problem, track, 14, fade), 0.0);
  EXPECT_NEAR(presenceAt(problem, track, 19, fade) + presenceAt(problem, track, 20, fade), 1.0,
              1e-12);
  EXPECT_EQ(presenceAt(problem, track, 25, fade), 1.0);
  EXPECT_EQ(presenceAt(problem, track, 99, fade), 1.0);
  fade.looks_ahead = false;
  EXPECT_EQ(presenceAt(problem, track, 19, fade), 0.0);
  EXPECT_GT(presenceAt(problem, track, 20, fade), 0.0);
  EXPECT_EQ(presenceAt(problem, track, 30, fade), 1.0);
}

}  // namespace
}  // namespace handgraft::manipulation
