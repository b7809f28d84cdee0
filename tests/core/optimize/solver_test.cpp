#include "core/optimize/solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

using test::randomPose;
using test::reachableProblem;

constexpr std::array kAllSolvers = {Solver::kLm,    Solver::kMma,   Solver::kCcsaq,
                                    Solver::kSlsqp, Solver::kLbfgs, Solver::kTnewton,
                                    Solver::kVar2};

PoseProblem reachable(unsigned seed) {
  std::mt19937 random(seed);
  const auto model = test::syntheticHand();
  return reachableProblem(model, randomPose(*model, random), 6, random);
}

SolveOptions optionsOf(Solver solver) {
  SolveOptions options;
  options.solver = solver;
  return options;
}

bool sameBits(const SolveReport& a, const SolveReport& b) {
  return a.pose.X_WH.matrix() == b.pose.X_WH.matrix() && a.pose.q == b.pose.q &&
         a.terms.objective == b.terms.objective && a.evaluations == b.evaluations &&
         a.best_start == b.best_start && a.outcome == b.outcome;
}

class EverySolver : public testing::TestWithParam<Solver> {};

TEST_P(EverySolver, FindsAPoseThatBringsAllPairsTogether) {
  const PoseProblem problem = reachable(1);
  const SolveReport report = solve(problem, optionsOf(GetParam()), Progress());
  for (const PatchFit& fit : report.patches)
    EXPECT_LT(fit.max_mm, 0.5) << fit.patch;
  EXPECT_EQ(report.solver, nameOf(GetParam()));
}

TEST_P(EverySolver, StaysInTheBounds) {
  PoseProblem problem = reachable(2);
  problem.upper[0] = 0.2;
  problem.start.q[0] = 0.1;
  problem.root_lower = Eigen::Vector3d::Constant(-0.1);
  problem.root_upper = Eigen::Vector3d::Constant(0.1);
  const SolveReport report = solve(problem, optionsOf(GetParam()), Progress());
  EXPECT_TRUE((report.pose.q.array() >= problem.lower.array()).all());
  EXPECT_TRUE((report.pose.q.array() <= problem.upper.array()).all());
  EXPECT_LE(report.pose.X_WH.translation().cwiseAbs().maxCoeff(), 0.1);
}

TEST_P(EverySolver, UsesNoMoreEvaluationsThanItMay) {
  const PoseProblem problem = reachable(3);
  for (const int most : {1, 2, 7, 100}) {
    SolveOptions options = optionsOf(GetParam());
    options.starts = 2;
    options.max_evaluations = most;
    EXPECT_LE(solve(problem, options, Progress()).evaluations, 2 * most);
  }
}

TEST_P(EverySolver, GivesTheSameBytesWhateverTheNumberOfThreads) {
  const PoseProblem problem = reachable(4);
  SolveOptions options = optionsOf(GetParam());
  options.starts = 5;
  options.max_evaluations = 300;
  const SolveReport one = solve(problem, options, Progress());
  options.threads = 3;
  EXPECT_TRUE(sameBits(one, solve(problem, options, Progress())));
}

TEST_P(EverySolver, ThrowsTheObserversOwnException) {
  const PoseProblem problem = reachable(5);
  SolveOptions options = optionsOf(GetParam());
  int calls = 0;
  options.on_improvement = [&calls](const hand::HandPose&, const Terms&) {
    if (++calls == 3) throw std::out_of_range("the observer's own");
  };
  EXPECT_THROW(solve(problem, options, Progress()), std::out_of_range);
  EXPECT_EQ(calls, 3);
}

INSTANTIATE_TEST_SUITE_P(Single,
                         EverySolver,
                         testing::ValuesIn(kAllSolvers),
                         [](const auto& test) {
                           return std::string(nameOf(test.param));
                         });

TEST(Solve, TurnsAHandThatIsFlippedAndFarAway) {
  // The normal term has no slope there; the closed-form start does not care.
  PoseProblem problem = reachable(6);
  problem.start.X_WH.linear() =
      rotationFromVector({0.0, std::numbers::pi, 0.0}) * problem.start.X_WH.linear();
  problem.start.X_WH.translation().setConstant(3.0);
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_LT(report.terms.objective, 1e-2);
}

TEST(Solve, RotatesFartherThanOneChartReaches) {
  // From its own start alone: the root has to turn by nearly half a turn.
  PoseProblem problem = makeProblem(test::rigidHand());
  problem.weights = {1e4, 0.0, 0.0};
  std::mt19937 random(7);
  const Eigen::Matrix3d R = rotationFromVector({0.0, 0.0, 3.0});
  for (int i = 0; i < 10; ++i) {
    PointPair pair;
    pair.p_L = 0.05 * test::randomUnit(random);
    pair.n_L = test::randomUnit(random);
    pair.p_W = R * pair.p_L;
    pair.n_W = -(R * pair.n_L);
    problem.pairs.push_back(pair);
  }
  SolveOptions options = optionsOf(Solver::kLbfgs);
  options.starts = 1;
  const SolveReport report = solve(problem, options, Progress());
  EXPECT_LT(report.terms.distance, 1e-12);
  EXPECT_EQ(report.outcome, Outcome::kConverged);
}

TEST(Solve, HoldsLockedDegreesOfFreedom) {
  PoseProblem problem = reachable(8);
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), false);
  problem.locked[1] = problem.locked[4] = problem.locked[7] = true;
  problem.start.X_WH.linear() = rotationFromVector({0.3, -0.2, 0.5});
  problem.start.X_WH.translation().setConstant(0.04);
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_NEAR(vectorFromRotation(report.pose.X_WH.linear())[1], -0.2, 1e-12);
  EXPECT_EQ(report.pose.X_WH.translation()[1], 0.04);
  EXPECT_EQ(report.pose.q[1], problem.start.q[1]);
}

TEST(Solve, ReturnsTheStartWhenEverythingIsLocked) {
  PoseProblem problem = reachable(9);
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), true);
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_EQ(report.pose.X_WH.matrix(), problem.start.X_WH.matrix());
  EXPECT_EQ(report.pose.q, problem.start.q);
  EXPECT_EQ(report.outcome, Outcome::kConverged);
}

TEST(Solve, CallsContradictingBoundsInfeasible) {
  PoseProblem problem = reachable(10);
  problem.lower[0] = 1.0;
  problem.upper[0] = 0.5;
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_EQ(report.outcome, Outcome::kInfeasible);
  EXPECT_EQ(report.pose.q, problem.start.q);
}

TEST(Solve, SaysWhenEvaluationsRanOut) {
  SolveOptions options;
  options.starts = 1;
  options.max_evaluations = 5;
  EXPECT_EQ(solve(reachable(11), options, Progress()).outcome, Outcome::kEvaluationLimit);
}

TEST(Solve, WithoutPairsRestsAtThePrior) {
  PoseProblem problem = makeProblem(test::syntheticHand());
  problem.prior.q.setConstant(0.01);
  problem.prior.X_WH.translation().setConstant(0.2);
  problem.prior.X_WH.linear() = rotationFromVector({0.0, 2.8, 0.0});
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_LT(report.terms.prior, 1e-6);
}

TEST(Solve, AnswersAProblemWithoutWeights) {
  PoseProblem problem = reachable(12);
  problem.weights = {0.0, 0.0, 0.0};
  const SolveReport report = solve(problem, SolveOptions(), Progress());
  EXPECT_EQ(report.terms.objective, 0.0);
  EXPECT_TRUE(report.pose.q.allFinite());
}

TEST(Solve, TellsOnlyOfBetterPosesOneAtATime) {
  SolveOptions options;
  options.threads = 3;
  double last = std::numeric_limits<double>::infinity();
  int calls = 0;
  options.on_improvement = [&](const hand::HandPose&, const Terms& terms) {
    EXPECT_LT(terms.objective, last);
    last = terms.objective;
    ++calls;
  };
  const SolveReport report = solve(reachable(13), options, Progress());
  EXPECT_GT(calls, 3);
  // The report sums over the points.
  EXPECT_NEAR(last, report.terms.objective, 1e-12);
}

TEST(Solve, StopsWhenCancelled) {
  Progress progress;
  SolveOptions options;
  options.threads = 2;
  options.on_improvement = [&progress](const auto&, const auto&) {
    progress.cancel();
  };
  EXPECT_THROW(solve(reachable(14), options, progress), Cancelled);
}

TEST(Solve, ReportsRisingProgressToOne) {
  std::vector<double> fractions;
  const Progress progress([&](std::string_view, double f) {
    fractions.push_back(f);
  });
  solve(reachable(15), SolveOptions(), progress);
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_NEAR(fractions.back(), 1.0, 1e-9);
}

TEST(Solve, RefusesOptionsOutOfRange) {
  const PoseProblem problem = reachable(16);
  SolveOptions options;
  options.starts = 0;
  EXPECT_THROW(solve(problem, options, Progress()), InvalidInput);
  options = {};
  options.threads = 0;
  EXPECT_THROW(solve(problem, options, Progress()), InvalidInput);
  options = {};
  options.max_evaluations = 0;
  EXPECT_THROW(solve(problem, options, Progress()), InvalidInput);
}

TEST(SolverFrom, NamesThePermittedSpellings) {
  for (const Solver solver : kAllSolvers)
    EXPECT_EQ(solverFrom(nameOf(solver)), solver);
  try {
    solverFrom("newton");
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("lm mma ccsaq slsqp lbfgs tnewton var2, or all"));
  }
}

TEST(AlignRoot, RecoversTheRootWhereThePairsFit) {
  std::mt19937 random(17);
  const auto model = test::syntheticHand();
  for (int k = 0; k < 20; ++k) {
    const hand::HandPose goal = randomPose(*model, random);
    const PoseProblem problem = reachableProblem(model, goal, 4, random);
    const Pose X_WH = alignRoot(problem, goal.q);
    EXPECT_LE((X_WH.matrix() - goal.X_WH.matrix()).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(AlignRoot, IsAProperRotationForAMirroredTarget) {
  std::mt19937 random(18);
  PoseProblem problem = test::randomProblem(test::rigidHand(), 8, random);
  for (PointPair& pair : problem.pairs) {
    pair.p_W = pair.p_L.cwiseProduct(Eigen::Vector3d(1.0, 1.0, -1.0));
    pair.n_W = -pair.n_L.cwiseProduct(Eigen::Vector3d(1.0, 1.0, -1.0));
  }
  const Eigen::Matrix3d R = alignRoot(problem, problem.start.q).linear();
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(AlignRoot, KeepsTheStartsRotationWhereThePairsLeaveItOpen) {
  PoseProblem problem = makeProblem(test::rigidHand());
  problem.start.X_WH.linear() = rotationFromVector({0.0, 0.0, 0.7});
  PointPair pair;
  pair.n_L = Eigen::Vector3d::UnitZ();
  pair.n_W = -Eigen::Vector3d::UnitZ();
  pair.p_W.setConstant(0.1);
  problem.pairs.push_back(pair);
  const Pose X_WH = alignRoot(problem, problem.start.q);
  EXPECT_LE((X_WH.linear() - problem.start.X_WH.linear()).norm(), 1e-5);
  EXPECT_LE((X_WH.translation() - pair.p_W).norm(), 1e-12);
}

TEST(AlignRoot, KeepsTheStartWithoutPairs) {
  PoseProblem problem = makeProblem(test::rigidHand());
  problem.start.X_WH.translation().setConstant(0.3);
  EXPECT_EQ(alignRoot(problem, problem.start.q).matrix(), problem.start.X_WH.matrix());
}

}  // namespace
}  // namespace handgraft::optimize
