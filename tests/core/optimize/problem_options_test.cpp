#include "core/optimize/problem_options.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

TEST(ProblemOptions, ScaleEachKindOfThePriorApart) {
  std::mt19937 random(61);
  PoseProblem problem = makeProblem(test::syntheticHand());
  problem.weights = {1.0, 1.0, 1.0};
  const hand::HandPose pose = test::randomPose(*problem.model, random);
  const double turn = vectorFromRotation(pose.X_WH.linear()).squaredNorm();
  const double shift = pose.X_WH.translation().squaredNorm();
  const double joints = (pose.q - problem.prior.q).squaredNorm();
  EXPECT_NEAR(Objective(problem).evaluate(pose).prior, turn + shift + joints, 1e-12);
  scalePrior({2.0, 3.0, 5.0}, problem);
  EXPECT_NEAR(Objective(problem).evaluate(pose).prior, 2.0 * turn + 3.0 * shift + 5.0 * joints,
              1e-12);
}

TEST(ProblemOptions, ScaleOnePatchAlone) {
  std::mt19937 random(62);
  PoseProblem problem = test::randomProblem(test::syntheticHand(), 30, random);
  PoseProblem without = problem;
  std::erase_if(without.pairs, [](const PointPair& pair) {
    return pair.patch == 1;
  });
  const hand::HandPose pose = test::randomPose(*problem.model, random);
  const double all = Objective(problem).evaluate(pose).distance;
  const double others = Objective(without).evaluate(pose).distance;
  scalePatch(1, 4.0, problem);
  EXPECT_NEAR(Objective(problem).evaluate(pose).distance, others + 4.0 * (all - others),
              1e-12 * all);
  EXPECT_THROW(scalePatch(7, 1.0, problem), InvalidInput);
}

TEST(ProblemOptions, HoldAJointTheMoreSoftlyTheLessItWeighs) {
  std::mt19937 random(63);
  const PoseProblem free = test::randomProblem(test::syntheticHand(), 30, random);
  const double wanted = 0.1;
  double last = std::numeric_limits<double>::infinity();
  for (const double weight : {1e2, 1e4, 1e6}) {
    PoseProblem problem = free;
    holdSoftly(0, wanted, weight, problem);
    const double off = std::abs(solve(problem, {}, Progress()).pose.q[0] - wanted);
    EXPECT_LT(off, last);
    last = off;
  }
  EXPECT_LT(last, 0.05);
}

TEST(ProblemOptions, LockHoldsTheStart) {
  std::mt19937 random(64);
  PoseProblem problem = test::randomProblem(test::syntheticHand(), 30, random);
  problem.start.q[0] = 0.7;
  lock(6, problem);
  EXPECT_EQ(solve(problem, {}, Progress()).pose.q[0], 0.7);
}

TEST(ProblemOptions, RefuseWhatIsNoWeightOrOutOfBounds) {
  PoseProblem problem = makeProblem(test::syntheticHand());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(scalePrior({-1.0, 1.0, 1.0}, problem), InvalidInput);
  EXPECT_THROW(scalePrior({1.0, nan, 1.0}, problem), InvalidInput);
  EXPECT_THROW(holdSoftly(0, 2.0, 1.0, problem), InvalidInput);
  EXPECT_THROW(holdSoftly(0, nan, 1.0, problem), InvalidInput);
  EXPECT_THROW(holdSoftly(0, 0.0, -1.0, problem), InvalidInput);
}

}  // namespace
}  // namespace handgraft::optimize
