#include "core/manipulation/offline_solver.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include "core/manipulation/causal_solver.h"
#include "core/manipulation/motion_objective.h"

#include "tests/core/manipulation/motions.h"

namespace handgraft::manipulation {
namespace {

using test::distanceOf;
using test::randomPose;
using test::reachableMotion;
using test::smoothPoses;

struct Scene {
  std::shared_ptr<const hand::HandModel> model = test::syntheticHand();
  std::mt19937 random{11};
  hand::HandPose from = randomPose(*model, random);
  hand::HandPose to = randomPose(*model, random);

  /// Contacts that no pose fits, at frames that are not evenly spaced.
  [[nodiscard]] MotionProblem unevenMotion(int frames) {
    MotionProblem problem =
        reachableMotion(model, smoothPoses(from, to, frames), 100.0, random);
    for (std::size_t k = 0; k < problem.time_s.size(); ++k)
      problem.time_s[k] += 0.003 * static_cast<double>(k % 3);
    std::normal_distribution<double> noise(0.0, 0.003);
    for (PairSpan& span : problem.tracks[0].spans)
      for (optimize::PointPair& pair : span.pairs)
        pair.p_W += Eigen::Vector3d(noise(random), noise(random), noise(random));
    return problem;
  }
};

std::vector<hand::HandPose> moved(const std::vector<hand::HandPose>& poses,
                                  std::size_t frame,
                                  int dof,
                                  double step) {
  std::vector<hand::HandPose> result = poses;
  result[frame] = test::moved(result[frame], dof, step);
  return result;
}

/// As many degrees of freedom a frame as its columns are padded to, and fewer.
class BandSystemOf : public ::testing::TestWithParam<int> {};

TEST_P(BandSystemOf, SolvesAsADenseOneDoes) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr int kFrames = 6;
  const int dofs = GetParam();
  BandSystem system(kFrames, dofs);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kFrames * dofs, kFrames * dofs);
  Eigen::VectorXd right(kFrames * dofs);
  const auto fill = [&](Coupling& coupling) {
    coupling.turn = Eigen::Matrix3d::NullaryExpr([&] {
      return normal(random);
    });
    coupling.others = Eigen::VectorXd::NullaryExpr(dofs - 3, [&] {
      return normal(random);
    });
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(dofs, dofs);
    block.topLeftCorner<3, 3>() = coupling.turn;
    block.diagonal().tail(dofs - 3) = coupling.others;
    return block;
  };
  for (int k = 0; k < kFrames; ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(dofs, dofs, [&] {
      return normal(random);
    });
    system.own[index] = A * A.transpose() + 30.0 * Eigen::MatrixXd::Identity(dofs, dofs);
    dense.block(k * dofs, k * dofs, dofs, dofs) = system.own[index];
    system.right[index] = Eigen::VectorXd::NullaryExpr(dofs, [&] {
      return normal(random);
    });
    right.segment(k * dofs, dofs) = system.right[index];
    for (const int ahead : {1, 2}) {
      if (k + ahead >= kFrames) continue;
      const Eigen::MatrixXd block = fill((ahead == 1 ? system.next : system.after_next)[index]);
      dense.block((k + ahead) * dofs, k * dofs, dofs, dofs) = block;
      dense.block(k * dofs, (k + ahead) * dofs, dofs, dofs) = block.transpose();
    }
  }
  std::vector<Eigen::VectorXd> solution;
  ASSERT_TRUE(BandCholesky().solve(system, solution));
  const Eigen::VectorXd expected = dense.ldlt().solve(right);
  for (int k = 0; k < kFrames; ++k)
    EXPECT_LT((solution[static_cast<std::size_t>(k)] - expected.segment(k * dofs, dofs)).norm(),
              1e-10)
        << k;
  system.own[3] -= 300.0 * Eigen::MatrixXd::Identity(dofs, dofs);
  EXPECT_FALSE(BandCholesky().solve(system, solution));
}

INSTANTIATE_TEST_SUITE_P(DofsOfAFrame, BandSystemOf, ::testing::Values(4, 5, 7, 8, 22, 30));

TEST(MotionObjective, GradientMatchesCentralDifferences) {
  Scene scene;
  MotionProblem problem = scene.unevenMotion(6);
  problem.velocity_limit.setConstant(0.4);
  problem.acceleration_limit.setConstant(15.0);
  MotionOptions options;
  optimize::WorkerPool pool(1);
  MotionObjective objective(problem, options, pool);
  std::vector<hand::HandPose> poses;
  for (int k = 0; k < 6; ++k) {
    hand::HandPose pose = scene.from;
    for (int dof = 0; dof < objective.dofCount(); ++dof)
      pose = test::moved(pose, dof, 0.03 * std::sin(3.0 * k + dof));
    poses.push_back(pose);
  }
  BandSystem system(6, objective.dofCount());
  const double size = objective.evaluateToExpand(poses);
  objective.takeModels();
  objective.expand(poses, system);
  for (std::size_t k = 0; k < 6; ++k) {
    for (int dof = 0; dof < objective.dofCount(); ++dof) {
      constexpr double kStep = 1e-6;
      const double slope = (objective.evaluate(moved(poses, k, dof, kStep)) -
                            objective.evaluate(moved(poses, k, dof, -kStep))) /
                           (2.0 * kStep);
      EXPECT_NEAR(-system.right[k][dof], slope, 1e-5 * (size + std::abs(slope)))
          << "frame " << k << ", dof " << dof;
    }
  }
}

TEST(MotionObjective, JoinsFramesByTheHessianWhereItsResidualsAreLinear) {
  // Joints and the root's place enter second differences linearly: the Hessian between frames
  // is that of finite differences of the gradient.
  Scene scene;
  const MotionProblem problem = scene.unevenMotion(5);
  optimize::WorkerPool pool(1);
  MotionObjective objective(problem, {}, pool);
  const std::vector<hand::HandPose> poses(5, scene.from);
  BandSystem system(5, objective.dofCount());
  const auto expand_at = [&](const std::vector<hand::HandPose>& at, BandSystem& into) {
    static_cast<void>(objective.evaluateToExpand(at));
    objective.takeModels();
    objective.expand(at, into);
  };
  expand_at(poses, system);
  BandSystem above(5, objective.dofCount());
  BandSystem below(5, objective.dofCount());
  constexpr double kStep = 1e-4;
  for (int dof = 0; dof < objective.dofCount(); ++dof) {
    expand_at(moved(poses, 2, dof, kStep), above);
    expand_at(moved(poses, 2, dof, -kStep), below);
    const auto slope = [&](std::size_t frame, int row) {
      return (below.right[frame][row] - above.right[frame][row]) / (2.0 * kStep);
    };
    for (int row = 0; row < objective.dofCount(); ++row) {
      const bool turns = dof < 3 && row < 3;
      const double next = turns ? system.next[2].turn(row, dof)
                                : (row == dof ? system.next[2].others[row - 3] : 0);
      const double after = turns ? system.after_next[2].turn(row, dof)
                                 : (row == dof ? system.after_next[2].others[row - 3] : 0);
      EXPECT_NEAR(slope(3, row), next, 1e-4 * (1.0 + std::abs(next))) << row << " by " << dof;
      EXPECT_NEAR(slope(4, row), after, 1e-4 * (1.0 + std::abs(after))) << row << " by " << dof;
    }
  }
}

TEST(OfflineSolver, IsTheSingleFramesAnswerWhereNothingMoves) {
  Scene scene;
  MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(15, scene.from), 120.0, scene.random);
  for (PairSpan& span : problem.tracks[0].spans)
    for (std::size_t i = 0; i < span.pairs.size(); ++i)
      span.pairs[i].p_W.x() += 0.004 * static_cast<double>(i % 3);
  const Trajectory trajectory = solveOffline(problem, {}, Progress());
  const FrameProblems frames(problem, Fade{});
  const hand::HandPose alone = solveSingle(problem, frames, 7, scene.from, {}, Progress()).pose;
  for (const hand::HandPose& pose : trajectory.poses)
    EXPECT_LT(distanceOf(pose, alone), 1e-3);
}

TEST(OfflineSolver, FindsAMotionThatFits) {
  Scene scene;
  const auto truth = smoothPoses(scene.from, scene.to, 60);
  const MotionProblem problem = reachableMotion(scene.model, truth, 120.0, scene.random);
  MotionOptions options;
  options.smoothness = 1e-3;
  const Trajectory trajectory = solveOffline(problem, options, Progress());
  EXPECT_LT(meanFit(fitFrames(problem, trajectory.poses)).mean_mm, 0.5);
}

TEST(OfflineSolver, IsTheSameWhenTimeRunsBackwards) {
  Scene scene;
  const MotionProblem problem = scene.unevenMotion(24);
  MotionProblem back = problem;
  const std::size_t last = problem.time_s.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    back.time_s[k] = problem.time_s[last] - problem.time_s[last - k];
    back.tracks[0].spans[k].pairs = problem.tracks[0].spans[last - k].pairs;
  }
  const std::vector<hand::HandPose> start = smoothPoses(scene.from, scene.to, 24);
  const Trajectory there = solveOffline(problem, {}, Progress(), start);
  const Trajectory again = solveOffline(back, {}, Progress(), {start.rbegin(), start.rend()});
  for (std::size_t k = 0; k <= last; ++k)
    EXPECT_LT(distanceOf(there.poses[k], again.poses[last - k]), 1e-3) << k;
}

TEST(OfflineSolver, IsSmootherTheMoreThatCounts) {
  Scene scene;
  const MotionProblem problem = scene.unevenMotion(40);
  double before = std::numeric_limits<double>::infinity();
  for (const double smoothness : {0.1, 10.0, 1000.0}) {
    MotionOptions options;
    options.smoothness = smoothness;
    const double jerk =
        measureSmoothness(problem, solveOffline(problem, options, Progress()).poses).rms_jerk;
    EXPECT_LT(jerk, 0.7 * before);
    before = jerk;
  }
}

TEST(OfflineSolver, KeepsAllLimits) {
  Scene scene;
  MotionProblem problem =
      reachableMotion(scene.model, smoothPoses(scene.from, scene.to, 60), 120.0, scene.random);
  MotionOptions options;
  options.smoothness = 0.1;
  const Smoothness loose =
      measureSmoothness(problem, solveOffline(problem, options, Progress()).poses);
  problem.velocity_limit.setConstant(0.5 * loose.max_velocity);
  problem.acceleration_limit.setConstant(0.5 * loose.max_acceleration);
  const Trajectory trajectory = solveOffline(problem, options, Progress());
  const Smoothness smoothness = measureSmoothness(problem, trajectory.poses);
  EXPECT_LE(smoothness.velocity_share, 1.0);
  EXPECT_LE(smoothness.acceleration_share, 1.0);
  for (const hand::HandPose& pose : trajectory.poses) {
    EXPECT_TRUE((pose.q.array() >= problem.lower.array()).all());
    EXPECT_TRUE((pose.q.array() <= problem.upper.array()).all());
  }
}

// A limit that the way asks for many times over was stuck, and made accelerations worse.
TEST(OfflineSolver, TightLimitsBringAccelerationsDownAndWhatIsBeyondIsNoted) {
  Scene scene;
  MotionProblem problem =
      reachableMotion(scene.model, smoothPoses(scene.from, scene.to, 60), 120.0, scene.random);
  MotionOptions options;
  options.smoothness = 0.1;
  const double loose =
      measureSmoothness(problem, solveOffline(problem, options, Progress()).poses)
          .max_acceleration;
  double before = loose;
  for (const double share : {0.5, 0.2, 0.1}) {
    problem.acceleration_limit.setConstant(share * loose);
    const Trajectory trajectory = solveOffline(problem, options, Progress());
    const Smoothness smoothness = measureSmoothness(problem, trajectory.poses);
    EXPECT_LT(smoothness.max_acceleration, before) << share;
    EXPECT_EQ(smoothness.acceleration_share > 1.01, !trajectory.notes.empty()) << share;
    before = smoothness.max_acceleration;
  }
}

TEST(OfflineSolver, AnswersTheSameBytesOnOneThreadAndOnTwo) {
  Scene scene;
  const MotionProblem problem = scene.unevenMotion(30);
  MotionOptions options;
  const Trajectory one = solveOffline(problem, options, Progress());
  options.threads = 2;
  const Trajectory two = solveOffline(problem, options, Progress());
  for (std::size_t k = 0; k < one.poses.size(); ++k) {
    EXPECT_EQ(one.poses[k].q, two.poses[k].q);
    EXPECT_EQ(one.poses[k].X_WH.matrix(), two.poses[k].X_WH.matrix());
  }
}

TEST(OfflineSolver, ALongMotionInPartsShowsNoSeam) {
  Scene scene;
  const MotionProblem problem = scene.unevenMotion(150);
  MotionOptions options;
  options.smoothness = 100.0;
  const Trajectory whole = solveOffline(problem, options, Progress());
  options.frames_at_once = 64;
  std::vector<double> told;
  const Progress listened([&](std::string_view stage, double fraction) {
    if (stage == "solving all frames") told.push_back(fraction);
  });
  const Trajectory parts = solveOffline(problem, options, listened);
  ASSERT_EQ(parts.poses.size(), 150U);
  for (std::size_t k = 0; k < 150; ++k)
    EXPECT_LT(distanceOf(whole.poses[k], parts.poses[k]), 2e-3) << k;
  EXPECT_LT(measureSmoothness(problem, parts.poses).rms_jerk,
            1.02 * measureSmoothness(problem, whole.poses).rms_jerk);
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_LT(told.back(), 1.0);
}

TEST(OfflineSolver, SolvesFramesAnewBetweenOthersThatStay) {
  Scene scene;
  MotionProblem problem = scene.unevenMotion(90);
  MotionOptions options;
  options.smoothness = 100.0;
  const Trajectory before = solveOffline(problem, options, Progress());
  const double there = before.poses[45].q[0];
  const double wanted = std::clamp(there + 0.1, problem.lower[0], problem.upper[0]);
  FrameOwn& own = problem.own[45];
  own.lower = problem.lower;
  own.upper = problem.upper;
  own.lower[0] = own.upper[0] = wanted;

  Trajectory again = before;
  solveAgain(problem, options, 20, 70, Progress(), again);
  EXPECT_EQ(again.poses[45].q[0], wanted);
  for (std::size_t k = 0; k < 90; ++k) {
    const bool stays = k < 20 || k >= 70;
    EXPECT_TRUE(!stays || again.poses[k].q == before.poses[k].q) << k;
    EXPECT_TRUE(!stays || again.poses[k].X_WH.matrix() == before.poses[k].X_WH.matrix()) << k;
  }
  const Trajectory whole = solveOffline(problem, options, Progress(), again.poses);
  for (std::size_t k = 0; k < 90; ++k)
    EXPECT_LT(distanceOf(whole.poses[k], again.poses[k]), 5e-3) << k;
}

TEST(OfflineSolver, AFrameOfItsOwnWeighsAndHoldsAsItSays) {
  Scene scene;
  MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(20, scene.from), 120.0, scene.random);
  const FrameProblems plain(problem, Fade{});
  const optimize::PoseProblem before = plain.at(10, scene.from);
  FrameOwn& own = problem.own[10];
  own.shares[0] = 0.25;
  own.pairs = {before.pairs.front()};
  own.soft_weights.assign(static_cast<std::size_t>(problem.model->dofCount()), 0.0);
  own.soft_values = own.soft_weights;
  own.soft_weights[0] = 3.0;
  own.soft_values[0] = problem.prior[0] + 0.4;
  const FrameProblems frames(problem, Fade{});
  const optimize::PoseProblem edited = frames.at(10, scene.from);
  ASSERT_EQ(edited.pairs.size(), before.pairs.size() + 1);
  EXPECT_EQ(edited.pairs.front().weight, 0.25 * before.pairs.front().weight);
  EXPECT_EQ(edited.pairs.back().weight, before.pairs.front().weight);
  EXPECT_EQ(edited.prior_weights[6], 4.0);
  EXPECT_NEAR(edited.prior.q[0], problem.prior[0] + 0.3, 1e-12);
  EXPECT_EQ(frames.at(9, scene.from).pairs.front().weight, before.pairs.front().weight);
}

TEST(OfflineSolver, WhatNothingHoldsComesToRest) {
  Scene scene;
  constexpr int kTouching = 30;
  auto poses = smoothPoses(scene.from, scene.to, 240);
  MotionProblem problem = reachableMotion(scene.model, poses, 120.0, scene.random);
  problem.tracks[0].spans.resize(kTouching);
  problem.tracks[0].end = kTouching;
  MotionOptions options;
  options.smoothness = 1e4;
  const Trajectory trajectory = solveOffline(problem, options, Progress());
  const auto step_at = [&](std::size_t k) {
    return distanceOf(trajectory.poses[k], trajectory.poses[k - 1]);
  };
  EXPECT_GT(step_at(kTouching - 2), 1e-3);
  EXPECT_LT(step_at(239), 0.02 * step_at(kTouching - 2));
}

TEST(OfflineSolver, TakesOneFrameAndTwo) {
  Scene scene;
  for (const int count : {1, 2}) {
    const MotionProblem problem = reachableMotion(
        scene.model, std::vector<hand::HandPose>(static_cast<std::size_t>(count), scene.from),
        120.0, scene.random);
    const Trajectory trajectory = solveOffline(problem, {}, Progress());
    EXPECT_LT(meanFit(fitFrames(problem, trajectory.poses)).mean_mm, 0.5) << count;
  }
}

TEST(OfflineSolver, DoesNotJumpWhereContactsVanishWhileOthersAppear) {
  Scene scene;
  constexpr int kFrames = 60;
  constexpr int kChange = 30;
  hand::HandPose near = scene.from;
  near.q += 0.3 * (scene.to.q - scene.from.q);
  MotionProblem problem = reachableMotion(
      scene.model, std::vector<hand::HandPose>(kFrames, scene.from), 120.0, scene.random);
  const MotionProblem other = reachableMotion(
      scene.model, std::vector<hand::HandPose>(kFrames, near), 120.0, scene.random);
  problem.tracks.push_back(other.tracks[0]);
  problem.tracks[0].end = kChange;
  problem.tracks[0].spans.resize(kChange);
  auto& later = problem.tracks[1].spans;
  later.erase(later.begin(), later.begin() + kChange);
  MotionOptions options;
  options.smoothness = 1000.0;
  const Trajectory trajectory = solveOffline(problem, options, Progress());
  const double way = (near.q - scene.from.q).cwiseAbs().maxCoeff();
  EXPECT_LT(measureSmoothness(problem, trajectory.poses).max_step, 0.3 * way);
  EXPECT_LT(distanceOf(trajectory.poses.front(), scene.from), 0.02);
  EXPECT_LT(distanceOf(trajectory.poses.back(), near), 0.02);
}

// A joint that has to leap at one time is slowed down there.
TEST(OfflineSolver, ALimitThatOneLeapBreaksIsKept) {
  Scene scene;
  hand::HandPose near = scene.from;
  near.q += 0.3 * (scene.to.q - scene.from.q);
  std::vector<hand::HandPose> poses(240, scene.from);
  std::fill(poses.begin() + 120, poses.end(), near);
  MotionProblem problem = reachableMotion(scene.model, poses, 120.0, scene.random);
  MotionOptions options;
  options.smoothness = 100.0;
  const Trajectory free = solveOffline(problem, options, Progress());
  problem.velocity_limit.setConstant(0.6 * measureSmoothness(problem, free.poses).max_velocity);
  problem.acceleration_limit.setConstant(
      0.9 * measureSmoothness(problem, free.poses).max_acceleration);
  const Smoothness broken = measureSmoothness(problem, free.poses);
  double share = 0.0;
  for (std::size_t k = 0; k < free.poses.size(); ++k)
    share = std::max(share, limitShareAt(problem, free.poses, k));
  EXPECT_NEAR(share, std::max(broken.velocity_share, broken.acceleration_share), 1e-9);
  EXPECT_GT(share, 1.5);
  const Trajectory kept = solveOffline(problem, options, Progress());
  EXPECT_LE(measureSmoothness(problem, kept.poses).velocity_share, 1.0);
  EXPECT_LE(measureSmoothness(problem, kept.poses).acceleration_share, 1.0);
  EXPECT_TRUE(kept.notes.empty());
}

}  // namespace
}  // namespace handgraft::manipulation
