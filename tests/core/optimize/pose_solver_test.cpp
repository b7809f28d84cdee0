#include "core/optimize/pose_solver.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/optimize/minima.h"
#include "core/optimize/starts.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

using test::randomProblem;

PoseProblem someProblem(unsigned seed) {
  std::mt19937 random(seed);
  return randomProblem(test::syntheticHand(), 40, random);
}

bool sameBits(const SolveReport& a, const SolveReport& b) {
  if (a.minima.size() != b.minima.size()) return false;
  for (std::size_t i = 0; i < a.minima.size(); ++i) {
    const Minimum& x = a.minima[i];
    const Minimum& y = b.minima[i];
    if (x.pose.X_WH.matrix() != y.pose.X_WH.matrix() || x.pose.q != y.pose.q ||
        x.terms.objective != y.terms.objective || x.start != y.start || x.hits != y.hits) {
      return false;
    }
  }
  return a.pose.q == b.pose.q && a.evaluations == b.evaluations;
}

TEST(PoseSolver, GivesTheSameBytesAgainAndOnAnyNumberOfThreads) {
  PoseSolver solver(someProblem(51));
  SolveOptions options;
  const SolveReport first = solver.search(options, Progress());
  EXPECT_TRUE(sameBits(first, solver.search(options, Progress())));
  for (const int threads : {2, 5, 1}) {
    options.threads = threads;
    EXPECT_TRUE(sameBits(first, solver.search(options, Progress()))) << threads;
  }
  EXPECT_TRUE(sameBits(first, PoseSolver(someProblem(51)).search(options, Progress())));
}

TEST(PoseSolver, RanksMinimaThatDiffer) {
  const PoseProblem problem = someProblem(52);
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  ASSERT_GE(report.minima.size(), 2U);
  EXPECT_EQ(report.minima.front().pose.q, report.pose.q);
  int hits = 0;
  for (std::size_t i = 0; i < report.minima.size(); ++i) {
    hits += report.minima[i].hits;
    EXPECT_LT(report.minima[i].start, report.starts);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_LE(report.minima[j].terms.objective, report.minima[i].terms.objective);
      EXPECT_FALSE(isSameMinimum(*problem.model, report.minima[i], report.minima[j]));
    }
  }
  EXPECT_LE(hits, report.starts);
}

TEST(PoseSolver, LeavesTheLastStartsOutOnlyWhereTheOthersAgree) {
  SolveOptions options;
  PoseProblem smooth = someProblem(71);
  smooth.weights.distance = smooth.weights.normal = 0.0;  // the prior alone: one minimum
  PoseSolver solver(smooth);
  const SolveReport one = solver.search(options, Progress());
  EXPECT_LT(one.starts, options.starts);
  EXPECT_NEAR(one.terms.objective, 0.0, 1e-9);
  options.starts = 20;  // too few to leave any out
  EXPECT_EQ(solver.search(options, Progress()).starts, 20);

  options.starts = 64;
  int full = 0;
  for (unsigned seed = 72; seed < 82; ++seed) {
    const SolveReport report = PoseSolver(someProblem(seed)).search(options, Progress());
    full += report.starts == options.starts ? 1 : 0;
  }
  EXPECT_GE(full, 1) << "random points leave many minima";
}

TEST(PoseSolver, RacesAllSolversAndNamesTheWinner) {
  PoseSolver solver(someProblem(53));
  SolveOptions options;
  options.starts = 4;
  options.solver = Solver::kAll;
  const SolveReport all = solver.search(options, Progress());
  EXPECT_NE(all.solver, "all");
  for (const Solver single : singleSolvers()) {
    options.solver = single;
    EXPECT_LE(all.terms.objective, solver.search(options, Progress()).terms.objective);
  }
}

TEST(PoseSolver, FindsWhatTheOthersFindFromTheirManyStarts) {
  for (unsigned seed = 54; seed < 59; ++seed) {
    PoseSolver solver(someProblem(seed));
    SolveOptions options;
    const double ours = solver.search(options, Progress()).terms.objective;
    options.solver = Solver::kSlsqp;
    const double theirs = solver.search(options, Progress()).terms.objective;
    EXPECT_LE(ours, 1.001 * theirs) << seed;
  }
}

TEST(PoseSolver, GoesThePapersWayFromThePrior) {
  PoseProblem problem = someProblem(60);
  SolveOptions options = paperOptions();
  EXPECT_EQ(options.starts, 1);
  options.max_evaluations = 1;
  const SolveReport report = solve(problem, options, Progress());
  EXPECT_EQ(report.solver, "mma");
  EXPECT_EQ(report.pose.q, problem.prior.q);
  EXPECT_EQ(report.pose.X_WH.matrix(), problem.prior.X_WH.matrix());
}

TEST(PoseSolver, ReportsTheSumsOverThePoints) {
  const PoseProblem problem = someProblem(61);
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  const Terms points = sumOverPoints(problem, report.pose);
  EXPECT_EQ(report.terms.objective, points.objective);
  EXPECT_NEAR(report.minima.front().terms.objective, points.objective,
              1e-12 * points.objective);
}

TEST(StartPose, StaysInItsBoundsAndKeepsLocks) {
  PoseProblem problem = someProblem(62);
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), false);
  problem.locked[6] = true;
  problem.start.q[0] = 0.3;
  const MomentTree tree = makeMomentTree(problem);
  for (int index = 0; index < 40; ++index) {
    const hand::HandPose pose = startPose(problem, tree, index, 3);
    EXPECT_TRUE((pose.q.array() >= problem.lower.array()).all()) << index;
    EXPECT_TRUE((pose.q.array() <= problem.upper.array()).all()) << index;
    EXPECT_EQ(pose.q[0], 0.3);
    const Eigen::Matrix3d R = pose.X_WH.linear();
    EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
}

TEST(StartPose, AboutAPoseMovesSomeJointsWithinTheirBounds) {
  PoseProblem problem = someProblem(64);
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), false);
  problem.locked[6] = true;
  const MomentTree tree = makeMomentTree(problem);
  const Eigen::Index joints = problem.start.q.size();
  Eigen::Index moved = 0;
  for (int index = 0; index < 60; ++index) {
    const hand::HandPose pose = startAbout(problem.start, problem, tree, index, 3);
    EXPECT_TRUE((pose.q.array() >= problem.lower.array()).all()) << index;
    EXPECT_TRUE((pose.q.array() <= problem.upper.array()).all()) << index;
    EXPECT_EQ(pose.q[0], problem.start.q[0]) << "locked";
    const Eigen::Index now = (pose.q.array() != problem.start.q.array()).count();
    EXPECT_LT(now, joints);
    moved += now;
    EXPECT_EQ(pose.q, startAbout(problem.start, problem, tree, index, 3).q);
  }
  EXPECT_NEAR(static_cast<double>(moved) / (60.0 * static_cast<double>(joints - 1)), 1.0 / 3.0,
              0.1);
  EXPECT_NE(startAbout(problem.start, problem, tree, 5, 3).q,
            startAbout(problem.start, problem, tree, 6, 3).q);
}

TEST(StartPose, TurnsTheRootAboutTheObjectsCentre) {
  const PoseProblem problem = someProblem(63);
  const MomentTree tree = makeMomentTree(problem);
  Eigen::Vector3d center_W = Eigen::Vector3d::Zero();
  double weight = 0.0;
  for (const BodyMoments& moments : tree.moments) {
    center_W += moments.weight * moments.x_W;
    weight += moments.weight;
  }
  center_W /= weight;
  const Pose X_WH = alignRoot(problem, tree, problem.start.q);
  const Eigen::Matrix3d R = rotationFromVector({0.4, 1.0, -0.3});
  const Pose turned = turnRoot(problem, tree, X_WH, R);
  EXPECT_LE((turned.linear() - R * X_WH.linear()).norm(), 1e-12);
  EXPECT_LE((inverse(turned) * center_W - inverse(X_WH) * center_W).norm(), 1e-12);
}

}  // namespace
}  // namespace handgraft::optimize
