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

std::shared_ptr<const geometry::Solid> solidOf(const geometry::TriangleMesh& mesh) {
  return std::make_shared<const geometry::Solid>(mesh, Progress());
}

/// A synthetic hand of balls, with joints of every kind, near an object of some 60 mm.
struct Scene {
  test::BallHand hand = test::withBalls(*test::syntheticHand(), kBall);
  std::shared_ptr<Avoidance> avoidance = std::make_shared<Avoidance>();

  explicit Scene(const geometry::TriangleMesh& object) {
    avoidance->hand =
        std::make_shared<const hand::HandSolid>(*hand.model, *hand.skin, Progress());
    avoidance->object_O = solidOf(object);
    avoidance->X_WO.linear() = rotationFromVector({0.3, -0.5, 0.2});
    avoidance->X_WO.translation() = Vector3d(0.1, -0.05, 0.02);
    avoidance->weight = 1e5;
    avoidance->margin_m = 4e-4;
    avoidance->self_margin_m = 4e-4;
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
  static const Scene the_scene(geometry::makeSphere(0.06, 4));
  return the_scene;
}

/// A plate of 3 mm: walls and edges.
const Scene& plateScene() {
  static const Scene the_scene(geometry::makeBox({0.12, 0.003, 0.1}));
  return the_scene;
}

/// A place where somebody is inside something, and which body that moves.
struct Depth {
  double area_m2 = 0.0;
  double depth = 0.0;
  int link = -1;
  Vector3d p_W = Vector3d::Zero();
  Vector3d slope_W = Vector3d::Zero();  ///< of the distance by the link's own place there
};

/// Of the hand in the object, and of the object's walls in the hand.
std::vector<Depth> depthsInObject(const Scene& scene, const hand::HandPose& pose) {
  const Avoidance& avoidance = *scene.avoidance;
  const hand::LinkPoses X_WL = forwardKinematics(*scene.hand.model, pose);
  const Pose X_OW = inverse(avoidance.X_WO);
  std::vector<Depth> depths;
  for (const hand::LinkSolid& solid : avoidance.hand->links()) {
    const Pose& X = X_WL[static_cast<std::size_t>(solid.link)];
    const auto add = [&](double area, double distance, const Vector3d& p_W,
                         const Vector3d& slope_W) {
      const double depth = avoidance.margin_m - distance;
      if (depth > 0.0) depths.push_back({area, depth, solid.link, p_W, slope_W});
    };
    Vector3d slope;
    for (const hand::SurfaceSample& sample : solid.fine.samples) {
      const double distance = avoidance.object_O->grid().at(X_OW * (X * sample.p_L), slope);
      add(sample.area_m2, distance, X * sample.p_L, avoidance.X_WO.linear() * slope);
    }
    for (const geometry::WallSample& sample : avoidance.object_O->walls().samples()) {
      const Vector3d p_W = avoidance.X_WO * sample.p;
      const double distance = solid.distance(inverse(X) * p_W, slope);
      add(sample.area_m2, distance, p_W, -(X.linear() * slope));
    }
  }
  return depths;
}

double sumOverSamples(const Scene& scene, const hand::HandPose& pose, bool itself) {
  const hand::LinkPoses X_WL = forwardKinematics(*scene.hand.model, pose);
  const auto& links = scene.avoidance->hand->links();
  const auto pose_of = [&](const hand::LinkSolid& solid) {
    return X_WL[static_cast<std::size_t>(solid.link)];
  };
  double sum = 0.0;
  for (const Depth& one : depthsInObject(scene, pose))
    sum += one.area_m2 / 1e-5 * one.depth * one.depth;
  if (!itself) return sum;
  for (const auto& [i, j] : scene.avoidance->hand->collisionPairs()) {
    for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)}) {
      const hand::LinkSolid& own = links[static_cast<std::size_t>(a)];
      const hand::LinkSolid& other = links[static_cast<std::size_t>(b)];
      for (const hand::SurfaceSample& sample : own.fine.samples) {
        const double depth =
            scene.avoidance->self_margin_m -
            other.distance(inverse(pose_of(other)) * (pose_of(own) * sample.p_L));
        if (depth > 0.0) sum += sample.area_m2 / 1e-5 * depth * depth;
      }
    }
  }
  return sum;
}

PoseProblem withoutTheCharge(PoseProblem problem) {
  problem.avoidance = nullptr;
  return problem;
}

class AvoidanceOf : public testing::TestWithParam<const Scene& (*)()> {};

TEST_P(AvoidanceOf, ChargesAreasTimesSquaredDepths) {
  const Scene& scene = GetParam()();
  std::mt19937 random(1);
  const PoseProblem problem = scene.problem(random);
  const PoseProblem bare = withoutTheCharge(problem);
  Objective objective(problem);
  Objective bare_objective(bare);
  int inside = 0;
  int in_itself = 0;
  for (int k = 0; k < 100; ++k) {
    const hand::HandPose pose = scene.poseInside(random);
    const Terms terms = objective.evaluate(pose);
    const Terms without = bare_objective.evaluate(pose);
    const double expected = sumOverSamples(scene, pose, true);
    EXPECT_NEAR(terms.penetration, expected, 1e-12 * expected);
    EXPECT_NEAR(terms.objective, without.objective + 1e5 * expected, 1e-9 * terms.objective);
    EXPECT_EQ(without.penetration, 0.0);
    inside += expected > 0.0 ? 1 : 0;
    in_itself += expected > sumOverSamples(scene, pose, false) ? 1 : 0;
  }
  EXPECT_GT(inside, 50);
  EXPECT_GT(in_itself, 10);
}

TEST_P(AvoidanceOf, AnswersAgainByTheLevelOfTheMoment) {
  const Scene& scene = GetParam()();
  std::mt19937 random(1);
  const PoseProblem problem = scene.problem(random);
  const PoseProblem bare = withoutTheCharge(problem);
  Objective objective(problem);
  Objective bare_objective(bare);
  int charged = 0;
  for (int k = 0; k < 20; ++k) {
    const hand::HandPose pose = scene.poseInside(random);
    const Terms first = objective.evaluate(pose);
    EXPECT_EQ(objective.evaluate(pose).objective, first.objective);
    objective.level({true, 0.0});
    EXPECT_EQ(objective.evaluate(pose).objective, bare_objective.evaluate(pose).objective);
    objective.level({true, 1.0});
    EXPECT_EQ(objective.evaluate(pose).objective, first.objective);
    charged += first.penetration > 0.0 ? 1 : 0;
  }
  EXPECT_GT(charged, 5);
}

TEST_P(AvoidanceOf, SaysTheSameBySomebodyElsesLists) {
  // As the frames of a motion: each has its lists, and one objective serves all in turns.
  const Scene& scene = GetParam()();
  std::mt19937 random(8);
  const PoseProblem problem = scene.problem(random);
  Objective turns(problem);
  std::vector<NearLists> lists(5);
  std::vector<hand::HandPose> poses;
  for (std::size_t k = 0; k < lists.size(); ++k)
    poses.push_back(scene.poseInside(random));
  for (int step = 0; step < 20; ++step) {
    for (std::size_t k = 0; k < lists.size(); ++k) {
      poses[k].X_WH.translation() += 0.0005 * test::randomUnit(random);
      const bool fine = step % 5 != 4;
      Objective alone(problem);
      alone.level({fine, 1.0});
      turns.level({fine, 1.0});
      turns.swapNear(lists[k]);
      const Terms terms = turns.evaluate(poses[k]);
      turns.swapNear(lists[k]);
      EXPECT_EQ(terms.penetration, alone.evaluate(poses[k]).penetration)
          << "pose " << k << ", step " << step;
    }
  }
}

TEST_P(AvoidanceOf, HasTheGradientOfCentralDifferences) {
  const Scene& scene = GetParam()();
  std::mt19937 random(2);
  const PoseProblem problem = scene.problem(random);
  Objective objective(problem);
  for (int k = 0; k < 40; ++k) {
    const hand::HandPose pose = scene.poseInside(random);
    Eigen::VectorXd gradient(problem.dofCount());
    objective.evaluate(pose, gradient);
    Eigen::VectorXd difference(problem.dofCount());
    const double step = 1e-6;
    for (int dof = 0; dof < problem.dofCount(); ++dof) {
      difference[dof] = (objective.evaluate(moved(pose, dof, step)).objective -
                         objective.evaluate(moved(pose, dof, -step)).objective) /
                        (2.0 * step);
    }
    // The fields' second derivatives jump from cell to cell.
    EXPECT_LT((gradient - difference).norm(), 1e-5 * gradient.norm());
  }
}

TEST_P(AvoidanceOf, HasTheGaussNewtonMatrixOfItsSamples) {
  const Scene& scene = GetParam()();
  std::mt19937 random(3);
  const PoseProblem problem = scene.problem(random);
  PoseProblem bare = problem;
  bare.avoidance = nullptr;
  int judged = 0;
  for (int k = 0; k < 400 && judged < 30; ++k) {
    const hand::HandPose pose = scene.poseInside(random);
    const double all = sumOverSamples(scene, pose, true);
    if (all == 0.0 || all > sumOverSamples(scene, pose, false)) continue;
    ++judged;
    const hand::LinkPoses X_WL = forwardKinematics(*scene.hand.model, pose);
    Eigen::MatrixXd expected = Objective(bare).gaussNewton(pose);
    for (const Depth& one : depthsInObject(scene, pose)) {
      Eigen::VectorXd row(problem.dofCount());
      row << (one.p_W - pose.X_WH.translation()).cross(one.slope_W), one.slope_W,
          pointJacobian(*scene.hand.model, X_WL, one.link, one.p_W)
                  .bottomRows<3>()
                  .transpose() *
              one.slope_W;
      expected += 2e5 * one.area_m2 / 1e-5 * row * row.transpose();
    }
    const Eigen::MatrixXd H = Objective(problem).gaussNewton(pose);
    EXPECT_LT((H - expected).norm(), 1e-10 * expected.norm());
  }
  EXPECT_EQ(judged, 30);
}

INSTANTIATE_TEST_SUITE_P(Objects,
                         AvoidanceOf,
                         testing::Values(&scene, &plateScene),
                         [](const auto& one) {
                           return one.index == 0 ? "Ball" : "Plate";
                         });

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

TEST(Avoidance, ReportsWhatAFreshLookSays) {
  std::mt19937 random(9);
  const PoseProblem problem = drawnInside(random);
  for (const int starts : {1, 2, 16}) {
    SolveOptions options;
    options.starts = starts;
    const SolveReport report = solve(problem, options, Progress());
    const Terms fresh = sumOverPoints(problem, report.pose);
    EXPECT_EQ(report.terms.objective, fresh.objective) << starts;
    EXPECT_EQ(report.terms.penetration, fresh.penetration) << starts;
  }
}

TEST(Avoidance, LeavesOtherSolversNothingToGain) {
  std::mt19937 random(6);
  double ours_in_all = 0.0;
  double papers_in_all = 0.0;
  for (int k = 0; k < 4; ++k) {
    PoseProblem problem = drawnInside(random);
    SolveOptions options;
    options.starts = 16;
    const SolveReport ours = solve(problem, options, Progress());
    ours_in_all += ours.terms.objective;
    papers_in_all += solve(problem, paperOptions(), Progress()).terms.objective;
    problem.start = ours.pose;
    options.starts = 1;
    for (const Solver solver : {Solver::kSlsqp, Solver::kLbfgs, Solver::kMma}) {
      options.solver = solver;
      EXPECT_NEAR(solve(problem, options, Progress()).terms.objective, ours.terms.objective,
                  1e-3 * ours.terms.objective)
          << nameOf(solver);
    }
  }
  EXPECT_LT(ours_in_all, papers_in_all);
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

TEST(Avoidance, GoesOnFromWhatASearchWithoutTheChargeFound) {
  std::mt19937 random(9);
  for (int k = 0; k < 3; ++k) {
    const PoseProblem problem = drawnInside(random);
    PoseProblem bare = problem;
    bare.avoidance = nullptr;
    SolveOptions options;
    options.starts = 12;
    const SolveReport whole = solve(problem, options, Progress());
    options.found = solve(bare, options, Progress()).minima;
    const SolveReport gone_on = solve(problem, options, Progress());
    EXPECT_TRUE(gone_on.pose.X_WH.matrix() == whole.pose.X_WH.matrix());
    EXPECT_TRUE(gone_on.pose.q == whole.pose.q);
    EXPECT_EQ(gone_on.terms.objective, whole.terms.objective);
    EXPECT_LT(gone_on.evaluations, whole.evaluations);
  }
}

TEST(Avoidance, SaysTheSameByTheListsOfASolveBefore) {
  std::mt19937 random(10);
  NearLists near;
  for (int k = 0; k < 4; ++k) {
    // Lists of another place, and of another object, say nothing of these.
    PoseProblem problem = drawnInside(random);
    if (k == 2) near.source.object_O = nullptr;
    for (int step = 0; step < 3; ++step) {
      SolveOptions options;
      options.starts = step == 0 ? 12 : 1;
      const SolveReport alone = solve(problem, options, Progress());
      options.near = &near;
      const SolveReport after = solve(problem, options, Progress());
      EXPECT_TRUE(after.pose.X_WH.matrix() == alone.pose.X_WH.matrix());
      EXPECT_TRUE(after.pose.q == alone.pose.q);
      EXPECT_EQ(after.terms.objective, alone.terms.objective);
      EXPECT_EQ(after.evaluations, alone.evaluations);
      EXPECT_EQ(near.source.object_O, problem.avoidance->object_O);
      problem.start = after.pose;
      problem.start.X_WH.translation() += 0.001 * test::randomUnit(random);
    }
  }
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
