#include "core/optimize/solve_report.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

PointPair pairAt(double distance_m, double angle_deg, int patch) {
  const double angle = angle_deg * 3.14159265358979323846 / 180.0;
  PointPair pair;
  pair.n_L = Eigen::Vector3d::UnitZ();
  pair.n_W = {std::sin(angle), 0.0, -std::cos(angle)};
  pair.p_W = {0.0, distance_m, 0.0};
  pair.patch = patch;
  return pair;
}

TEST(PatchFit, HoldsDistancesInMillimetresAndAnglesInDegrees) {
  PoseProblem problem = makeProblem(test::rigidHand());
  problem.pairs = {pairAt(0.001, 0.0, 4), pairAt(0.004, 30.0, 4), pairAt(0.007, 60.0, 4),
                   pairAt(0.05, 180.0, 1), pairAt(9.0, 90.0, -1)};
  const std::vector<PatchFit> fits = fitPatches(problem, problem.start);
  ASSERT_EQ(fits.size(), 2U);
  EXPECT_EQ(fits[0].patch, 1);
  EXPECT_NEAR(fits[0].max_mm, 50.0, 1e-9);
  EXPECT_NEAR(fits[0].normal_mean_deg, 180.0, 1e-9);
  EXPECT_EQ(fits[1].patch, 4);
  EXPECT_EQ(fits[1].point_count, 3);
  EXPECT_NEAR(fits[1].mean_mm, 4.0, 1e-9);
  EXPECT_NEAR(fits[1].rms_mm, std::sqrt(22.0), 1e-9);
  EXPECT_NEAR(fits[1].max_mm, 7.0, 1e-9);
  EXPECT_NEAR(fits[1].normal_mean_deg, 30.0, 1e-9);
  EXPECT_NEAR(fits[1].within_2mm, 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(fits[1].within_5mm, 2.0 / 3.0, 1e-12);
}

TEST(PatchFit, IsEmptyWithoutPatches) {
  const PoseProblem problem = makeProblem(test::rigidHand());
  EXPECT_TRUE(fitPatches(problem, problem.start).empty());
}

TEST(ActiveLimit, NamesTheSideAndLeavesLockedJointsOut) {
  PoseProblem problem = makeProblem(test::syntheticHand());
  hand::HandPose pose = problem.start;
  pose.q << 1.6, 0.0, -0.01, 0.0;
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), false);
  problem.locked[9] = true;
  const std::vector<ActiveLimit> limits = activeLimits(problem, pose);
  ASSERT_EQ(limits.size(), 2U);
  EXPECT_EQ(limits[0].dof, 0);
  EXPECT_TRUE(limits[0].upper);
  EXPECT_EQ(limits[1].dof, 2);
  EXPECT_FALSE(limits[1].upper);
}

}  // namespace
}  // namespace handgraft::optimize
