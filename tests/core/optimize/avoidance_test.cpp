#include "core/optimize/avoidance.h"

#include <cstring>
#include <random>

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

#include "tests/core/optimize/problems.h"
#include "tests/support/ball_hand.h"

namespace handgraft::optimize {
namespace {

using Eigen::Vector3d;
using test::moved;
using test::randomPose;

constexpr double kBall = 0.02;  // m, of each link

std::shared_ptr<const geometry::DistanceGrid> gridOf(const geometry::TriangleMesh& mesh) {
  return std::make_shared<const geometry::DistanceGrid>(
      std::make_shared<const geometry::SignedDistance>(mesh), geometry::DistanceGridOptions(),
      Progress());
}

/// A synthetic hand of balls, with joints of every kind, near a ball of 60 mm.
struct Scene {
  test::BallHand hand = test::withBalls(*test::syntheticHand(), kBall);
  std::shared_ptr<Avoidance> avoidance = std::make_shared<Avoidance>();

  Scene() {
    avoidance->hand =
        std::make_shared<const hand::HandSolid>(*hand.model, *hand.skin, Progress());
    avoidance->object_O = gridOf(geometry::makeSphere(0.06, 4));
    avoidance->X_WO.linear() = rotationFromVector({0.3, -0.5, 0.2});
    avoidance->X_WO.translation() = Vector3d(0.1, -0.05, 0.02);
  }

  /// Pairs, weights and prior at random; the object counts.
  [[nodiscard]] PoseProblem problem(std::mt19937& random) const {
    PoseProblem problem = test::randomProblem(hand.model, 40, random);
    problem.weights.distance = 100.0;
    problem.avoidance = avoidance;
    return problem;
  }

  /// Random joints, the root so near that links lie inside the object.
  [[nodiscard]] hand::HandPose poseInside(std::mt19937& random) const {
    hand::HandPose pose = randomPose(*hand.model, random);
    pose.X_WH.translation() = avoidance->X_WO.translation() + 0.06 * test::randomUnit(random);
    return pose;
  }
};

const Scene& scene() {
  static const Scene the_scene;
  return the_scene;
}

double sumOverSamples(const Scene& scene, const hand::HandPose& pose, bool itself) {
  const hand::LinkPoses X_WL = forwardKinematics(*scene.hand.model, pose);
  const auto& links = scene.avoidance->hand->links();
  const auto poseOf = [&](const hand::LinkSolid& solid) {
    return X_WL[static_cast<std::size_t>(solid.link)];
  };
  double sum = 0.0;
  const auto add = [&sum](const hand::SurfaceSample& sample, double distance) {
    if (distance < 0.0) sum += sample.area_m2 / 1e-5 * distance * distance;
  };
  for (const hand::LinkSolid& solid : links) {
    for (const hand::SurfaceSample& sample : solid.coarse.samples) {
      const Vector3d p_W = poseOf(solid) * sample.p_L;
      add(sample, scene.avoidance->object_O->at(inverse(scene.avoidance->X_WO) * p_W));
    }
  }
  if (!itself) return sum;
  for (const auto& [i, j] : scene.avoidance->hand->strangers()) {
    for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)}) {
      const hand::LinkSolid& own = links[static_cast<std::size_t>(a)];
      const hand::LinkSolid& other = links[static_cast<std::size_t>(b)];
      for (const hand::SurfaceSample& sample : own.coarse.samples)
        add(sample, other.distance(inverse(poseOf(other)) * (poseOf(own) * sample.p_L)));
    }
  }
  return sum;
}

TEST(Avoidance, ChargesAreasTimesSquaredDepths) {
  std::mt19937 random(1);
  const PoseProblem problem = scene().problem(random);
  PoseProblem bare = problem;
  bare.avoidance = nullptr;
  Objective objective(problem);
  Objective bare_objective(bare);
  int inside = 0;
  int in_itself = 0;
  for (int k = 0; k < 100; ++k) {
    const hand::HandPose pose = scene().poseInside(random);
    const Terms terms = objective.evaluate(pose);
    const Terms without = bare_objective.evaluate(pose);
    const double expected = sumOverSamples(scene(), pose, true);
    EXPECT_NEAR(terms.penetration, expected, 1e-12 * expected);
    EXPECT_NEAR(terms.objective, without.objective + 1e5 * expected, 1e-9 * terms.objective);
    EXPECT_EQ(without.penetration, 0.0);
    inside += expected > 0.0 ? 1 : 0;
    in_itself += expected > sumOverSamples(scene(), pose, false) ? 1 : 0;
  }
  EXPECT_GT(inside, 80);
  EXPECT_GT(in_itself, 10);
}

TEST(Avoidance, HasTheGradientOfCentralDifferences) {
  std::mt19937 random(2);
  const PoseProblem problem = scene().problem(random);
  Objective objective(problem);
  for (int k = 0; k < 40; ++k) {
    const hand::HandPose pose = scene().poseInside(random);
    Eigen::VectorXd gradient(problem.dofCount());
    objective.evaluate(pose, gradient);
    Eigen::VectorXd difference(problem.dofCount());
    const double step = 1e-6;
    for (int dof = 0; dof < problem.dofCount(); ++dof) {
      difference[dof] = (objective.evaluate(moved(pose, dof, step)).objective -
                         objective.evaluate(moved(pose, dof, -step)).objective) /
                        (2.0 * step);
    }
    EXPECT_LT((gradient - difference).norm(), 1e-6 * gradient.norm());
  }
}

TEST(Avoidance, HasTheGaussNewtonMatrixOfItsSamples) {
  std::mt19937 random(3);
  const PoseProblem problem = scene().problem(random);
  PoseProblem bare = problem;
  bare.avoidance = nullptr;
  const Pose X_OW = inverse(scene().avoidance->X_WO);
  int judged = 0;
  for (int k = 0; k < 200 && judged < 30; ++k) {
    const hand::HandPose pose = scene().poseInside(random);
    const double all = sumOverSamples(scene(), pose, true);
    if (all == 0.0 || all > sumOverSamples(scene(), pose, false)) continue;
    ++judged;
    const hand::LinkPoses X_WL = forwardKinematics(*scene().hand.model, pose);
    Eigen::MatrixXd expected = Objective(bare).gaussNewton(pose);
    for (const hand::LinkSolid& solid : scene().avoidance->hand->links()) {
      for (const hand::SurfaceSample& sample : solid.coarse.samples) {
        const Vector3d p_W = X_WL[static_cast<std::size_t>(solid.link)] * sample.p_L;
        Vector3d slope_O;
        if (scene().avoidance->object_O->at(X_OW * p_W, slope_O) >= 0.0) continue;
        const Vector3d slope_W = X_OW.linear().transpose() * slope_O;
        Eigen::VectorXd row(problem.dofCount());
        row << (p_W - pose.X_WH.translation()).cross(slope_W), slope_W,
            pointJacobian(*scene().hand.model, X_WL, solid.link, p_W)
                    .bottomRows<3>()
                    .transpose() *
                slope_W;
        expected += 2e5 * sample.area_m2 / 1e-5 * row * row.transpose();
      }
    }
    const Eigen::MatrixXd H = Objective(problem).gaussNewton(pose);
    EXPECT_LT((H - expected).norm(), 1e-10 * expected.norm());
  }
  EXPECT_EQ(judged, 30);
}

TEST(Avoidance, BoundsTheGaussNewtonMatrixOfAHandInItselfFromAbove) {
  std::mt19937 random(4);
  PoseProblem problem = scene().problem(random);
  PoseProblem bare = problem;
  bare.avoidance = nullptr;
  Avoidance far = *scene().avoidance;
  far.X_WO.translation() = Vector3d(9, 9, 9);
  problem.avoidance = std::make_shared<const Avoidance>(far);
  int judged = 0;
  for (int k = 0; k < 300; ++k) {
    const hand::HandPose pose = scene().poseInside(random);
    Objective objective(problem);
    if (objective.evaluate(pose).penetration == 0.0) continue;
    ++judged;
    const Eigen::MatrixXd own = objective.gaussNewton(pose) - Objective(bare).gaussNewton(pose);
    EXPECT_LT((own - own.transpose()).norm(), 1e-9 * own.norm());
    EXPECT_EQ(own.topRows(6).norm(), 0.0) << "the root moves no link against another";
    // Along the gradient of a sum of squares: g^T H g >= |g|^4 / (2 sum).
    Eigen::VectorXd with(problem.dofCount());
    Eigen::VectorXd without(problem.dofCount());
    const double sum = 1e5 * objective.evaluate(pose, with).penetration;
    Objective(bare).evaluate(pose, without);
    const Eigen::VectorXd g = with - without;
    EXPECT_GE(g.dot(own * g), 0.999 * g.squaredNorm() * g.squaredNorm() / (2.0 * sum));
  }
  EXPECT_GT(judged, 20);
}

/// Pairs that draw every link to the object's middle: without a charge the hand ends in there.
PoseProblem drawnInside(std::mt19937& random) {
  PoseProblem problem = scene().problem(random);
  problem.weights.distance = 1e3;
  for (PointPair& pair : problem.pairs)
    pair.p_W = scene().avoidance->X_WO * Vector3d(0.02 * test::randomUnit(random));
  problem.start = scene().poseInside(random);
  problem.start.q =
      problem.start.q.cwiseMax(problem.lower.cwiseMax(-3.0)).cwiseMin(problem.upper);
  problem.prior = problem.start;
  return problem;
}

TEST(Avoidance, KeepsAHandOut) {
  std::mt19937 random(5);
  for (int k = 0; k < 5; ++k) {
    const PoseProblem problem = drawnInside(random);
    PoseProblem bare = problem;
    bare.avoidance = nullptr;
    SolveOptions options;
    options.starts = 8;
    const SolveReport with = solve(problem, options, Progress());
    const SolveReport without = solve(bare, options, Progress());
    const double before = sumOverSamples(scene(), without.pose, true);
    EXPECT_LT(with.terms.penetration, 0.05 * before);
    EXPECT_NEAR(with.terms.penetration, sumOverSamples(scene(), with.pose, true),
                1e-9 * before);
    EXPECT_NEAR(with.terms.objective,
                problem.weights.distance * with.terms.distance +
                    problem.weights.normal * with.terms.normal +
                    problem.weights.prior * with.terms.prior + 1e5 * with.terms.penetration,
                1e-9 * with.terms.objective);
  }
}

TEST(Avoidance, LeavesOtherSolversNothingToGain) {
  std::mt19937 random(6);
  PoseProblem problem = drawnInside(random);
  SolveOptions options;
  options.starts = 16;
  const SolveReport ours = solve(problem, options, Progress());
  const double before = solve(problem, paperOptions(), Progress()).terms.objective;
  EXPECT_LT(ours.terms.objective, before);
  problem.start = ours.pose;
  options.starts = 1;
  for (const Solver solver : {Solver::kSlsqp, Solver::kLbfgs, Solver::kMma}) {
    options.solver = solver;
    EXPECT_NEAR(solve(problem, options, Progress()).terms.objective, ours.terms.objective,
                1e-3 * ours.terms.objective)
        << nameOf(solver);
  }
}

TEST(Avoidance, GivesTheSameBytesOnTwoThreads) {
  std::mt19937 random(7);
  const PoseProblem problem = drawnInside(random);
  SolveOptions options;
  options.starts = 12;
  const SolveReport one = solve(problem, options, Progress());
  options.threads = 2;
  const SolveReport two = solve(problem, options, Progress());
  EXPECT_EQ(std::memcmp(one.pose.q.data(), two.pose.q.data(),
                        sizeof(double) * static_cast<std::size_t>(one.pose.q.size())),
            0);
  EXPECT_TRUE(one.pose.X_WH.matrix() == two.pose.X_WH.matrix());
  EXPECT_EQ(one.terms.objective, two.terms.objective);
}

TEST(Avoidance, IsRefusedWithoutSense) {
  std::mt19937 random(8);
  PoseProblem problem = scene().problem(random);
  auto avoidance = std::make_shared<Avoidance>(*scene().avoidance);
  avoidance->weight = -1.0;
  problem.avoidance = avoidance;
  EXPECT_THROW(validate(problem), InvalidInput);
  avoidance->weight = 1.0;
  avoidance->X_WO.translation().x() = NAN;
  EXPECT_THROW(validate(problem), InvalidInput);
}

}  // namespace
}  // namespace handgraft::optimize
