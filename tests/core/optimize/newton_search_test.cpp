#include "core/optimize/newton_search.h"

#include <functional>

#include <gtest/gtest.h>

#include "core/optimize/local_search.h"
#include "core/optimize/starts.h"

#include "tests/core/optimize/allocation_count.h"
#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

using test::randomPose;
using test::randomProblem;

/// A search of a problem with all that it refers to.
struct Search {
  explicit Search(PoseProblem source)
      : problem(std::move(source)),
        prepared(problem),
        objective(problem, prepared.tree),
        newton(problem, prepared.space, objective) {}

  NewtonSearch::Step run(const hand::HandPose& start, int evaluations) {
    newton.begin(start);
    auto step = NewtonSearch::Step::kBetter;
    while (step == NewtonSearch::Step::kBetter)
      step = newton.improve(evaluations);
    left = evaluations;
    return step;
  }

  PoseProblem problem;
  PreparedProblem prepared;
  Objective objective;
  NewtonSearch newton;
  int left = 0;
};

/// Points where the hand could not go: bounds matter.
PoseProblem boundedProblem(std::mt19937& random) {
  PoseProblem problem = randomProblem(test::syntheticHand(), 60, random);
  problem.start = randomPose(*problem.model, random);
  problem.upper[0] = 0.4;
  problem.start.q[0] = std::min(problem.start.q[0], 0.4);
  return problem;
}

TEST(NewtonSearch, EndsWhereNoCoordinateCanGoDownhill) {
  std::mt19937 random(41);
  int at_bounds = 0;
  for (int k = 0; k < 50; ++k) {
    Search search(boundedProblem(random));
    search.newton.settings.promise = 1e-15;
    EXPECT_EQ(search.run(search.problem.start, 500), NewtonSearch::Step::kConverged);
    const hand::HandPose& end = search.newton.pose();
    QuadraticModel model(search.problem.dofCount());
    const Terms terms = search.objective.evaluate(end);
    EXPECT_EQ(terms.objective, search.newton.terms().objective);
    search.objective.expand(model);
    for (int dof = 0; dof < search.problem.dofCount(); ++dof) {
      // What a step along this coordinate alone would gain.
      const double slope = model.gradient[dof];
      const double gain = slope * slope / model.gauss_newton(dof, dof);
      const bool at_lower = dof >= 6 && end.q[dof - 6] <= search.problem.lower[dof - 6];
      const bool at_upper = dof >= 6 && end.q[dof - 6] >= search.problem.upper[dof - 6];
      at_bounds += at_lower || at_upper ? 1 : 0;
      if ((at_lower && slope > 0.0) || (at_upper && slope < 0.0)) continue;
      EXPECT_LE(gain, 1e-10 * terms.objective) << dof;
    }
  }
  EXPECT_GT(at_bounds, 20);
}

TEST(NewtonSearch, NeverLeavesTheBoxNorRises) {
  std::mt19937 random(42);
  for (int k = 0; k < 30; ++k) {
    Search search(boundedProblem(random));
    search.newton.begin(search.problem.start);
    double last = search.newton.terms().objective;
    int evaluations = 200;
    while (search.newton.improve(evaluations) == NewtonSearch::Step::kBetter) {
      const Eigen::VectorXd& q = search.newton.pose().q;
      ASSERT_TRUE((q.array() >= search.problem.lower.array()).all());
      ASSERT_TRUE((q.array() <= search.problem.upper.array()).all());
      ASSERT_LT(search.newton.terms().objective, last);
      last = search.newton.terms().objective;
    }
  }
}

TEST(NewtonSearch, ConvergesQuadraticallyToALargeResidual) {
  // The Gauss-Newton matrix alone would creep: the residual's curvature is of its own order.
  std::mt19937 random(43);
  for (int k = 0; k < 20; ++k) {
    Search search(randomProblem(test::syntheticHand(), 60, random));
    const hand::HandPose start = startPose(search.problem, *search.prepared.tree, 1, 0);
    ASSERT_EQ(search.run(start, 500), NewtonSearch::Step::kConverged);
    hand::HandPose near = search.newton.pose();
    near.q += Eigen::VectorXd::Constant(near.q.size(), 1e-3);
    near.q = near.q.cwiseMax(search.problem.lower).cwiseMin(search.problem.upper);
    near.X_WH.linear() = rotationFromVector({1e-3, 2e-3, -1e-3}) * near.X_WH.linear();
    search.newton.settings.first_damping = 1e-9;
    search.newton.settings.promise = 1e-14;
    ASSERT_EQ(search.run(near, 500), NewtonSearch::Step::kConverged);
    EXPECT_LE(500 - search.left, 6);
  }
}

TEST(NewtonSearch, AllocatesNothingOnItsWay) {
  if (!test::countsAllocations()) GTEST_SKIP() << "a sanitizer owns the allocator";
  std::mt19937 random(44);
  Search search(boundedProblem(random));
  search.newton.begin(search.problem.start);
  int evaluations = 200;
  const long before = test::allocationCount();
  while (search.newton.improve(evaluations) == NewtonSearch::Step::kBetter) {
  }
  EXPECT_EQ(test::allocationCount(), before);
  EXPECT_LT(evaluations, 195);
}

TEST(NewtonSearch, CountsAllocationsWhereThereAreSome) {
  if (!test::countsAllocations()) GTEST_SKIP() << "a sanitizer owns the allocator";
  const long before = test::allocationCount();
  const Eigen::VectorXd vector = Eigen::VectorXd::Ones(10);
  EXPECT_GT(test::allocationCount(), before) << vector.sum();
}

TEST(LocalSearch, WarmsUpByTheOtherFormOfTheNormalTerm) {
  std::mt19937 random(45);
  PoseProblem problem = randomProblem(test::syntheticHand(), 40, random);
  problem.weights.distance = 1.0;
  PoseProblem other = problem;
  other.normal_form = NormalForm::kSum;
  const PreparedProblem prepared(problem);
  LocalSearch search(prepared);
  const std::function<void()> keep_going = [] {};
  const LocalSearch::Observer observer;
  search.attend(observer, keep_going);
  const LocalResult result = search.begin(problem.start, 200);
  EXPECT_LE(result.evaluations, 201);
  EXPECT_EQ(result.terms.objective, Objective(problem).evaluate(result.pose).objective);
  // A minimum of the other form, not of the problem's own.
  Eigen::VectorXd gradient;
  Eigen::VectorXd other_gradient;
  Objective(problem).evaluate(result.pose, gradient);
  Objective(other).evaluate(result.pose, other_gradient);
  EXPECT_LE(other_gradient.head<6>().norm(), 1e-2 * gradient.head<6>().norm());
}

TEST(SearchSpace, PutsFingersApartAndTheRootLast) {
  std::mt19937 random(46);
  const PoseProblem problem = randomProblem(test::syntheticHand(), 100, random);
  const SearchSpace space = makeSearchSpace(problem, makeMomentTree(problem));
  // Finger b tip first, finger a (one dof, its follower shares it), the root.
  EXPECT_EQ(space.dofs, (std::vector<int>{9, 8, 7, 6, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(space.first, (std::vector<int>{0, 0, 0, 3, 0, 0, 0, 0, 0, 0}));
}

TEST(SearchSpace, EnvelopeHoldsEveryEntryOfTheHessian) {
  std::mt19937 random(47);
  PoseProblem problem = randomProblem(test::syntheticHand(), 100, random);
  problem.locked.assign(10, false);
  problem.locked[7] = problem.locked[1] = true;
  Objective objective(problem);
  const SearchSpace space = makeSearchSpace(problem, objective.tree());
  EXPECT_TRUE(space.rotation_partly_locked);
  EXPECT_EQ(space.dofs.size(), 8U);
  QuadraticModel model(problem.dofCount());
  static_cast<void>(objective.evaluate(randomPose(*problem.model, random)));
  objective.expand(model);
  const Eigen::MatrixXd H = model.gauss_newton + model.residual_curvature;
  for (std::size_t i = 0; i < space.dofs.size(); ++i) {
    for (int j = 0; j < space.first[i]; ++j) {
      EXPECT_EQ(H(space.dofs[i], space.dofs[static_cast<std::size_t>(j)]), 0.0)
          << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace handgraft::optimize
