#include "core/optimize/objective.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/urdf_file.h"

#include "tests/core/optimize/problems.h"
#include "tests/support/shared_data.h"

namespace handgraft::optimize {
namespace {

using test::moved;
using test::randomPose;
using test::randomProblem;

/// Richardson's central difference: error O(step^4).
double slopeAt(Objective& objective, const hand::HandPose& pose, int dof, double step) {
  const auto difference = [&](double h) {
    return (objective.evaluate(moved(pose, dof, h)).objective -
            objective.evaluate(moved(pose, dof, -h)).objective) /
           (2.0 * h);
  };
  return (4.0 * difference(step) - difference(2.0 * step)) / 3.0;
}

void expectGradientMatches(const PoseProblem& problem, std::mt19937& random, int poses) {
  Objective objective(problem);
  Eigen::VectorXd gradient;
  for (int k = 0; k < poses; ++k) {
    const hand::HandPose pose = randomPose(*problem.model, random);
    objective.evaluate(pose, gradient);
    Eigen::VectorXd expected(problem.dofCount());
    for (int i = 0; i < problem.dofCount(); ++i) {
      expected[i] = slopeAt(objective, pose, i, 1e-4);
    }
    EXPECT_LE((gradient - expected).norm(), 1e-6 * expected.norm())
        << problem.model->name() << ", pose " << k;
  }
}

/// Eq. 2-5 pair by pair, as the paper writes them.
Terms directTerms(const PoseProblem& problem, const hand::HandPose& pose) {
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, pose);
  Terms terms;
  for (const PointPair& pair : problem.pairs) {
    const Pose& X = X_WL[static_cast<std::size_t>(pair.link)];
    const double cosine = (X.linear() * pair.n_L).dot(pair.n_W);
    terms.distance += pair.weight * (pair.p_W - X * pair.p_L).squaredNorm();
    if (pair.has_normals) terms.normal += pair.weight * (1.0 + cosine) * (1.0 + cosine);
  }
  const auto weight = [&](int i) {
    return problem.prior_weights.size() == 0 ? 1.0 : problem.prior_weights[i];
  };
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d(problem.prior.X_WH.linear().transpose() * pose.X_WH.linear()));
  terms.prior = (weight(0) + weight(1) + weight(2)) / 3.0 * turn.angle() * turn.angle();
  for (int i = 0; i < 3; ++i) {
    terms.prior +=
        weight(3 + i) *
        std::pow(pose.X_WH.translation()[i] - problem.prior.X_WH.translation()[i], 2);
  }
  for (int j = 0; j < problem.model->dofCount(); ++j) {
    terms.prior += weight(6 + j) * std::pow(pose.q[j] - problem.prior.q[j], 2);
  }
  terms.objective = problem.weights.distance * terms.distance +
                    problem.weights.normal * terms.normal + problem.weights.prior * terms.prior;
  return terms;
}

void expectTermsMatch(const PoseProblem& problem, std::mt19937& random) {
  Objective objective(problem);
  for (int k = 0; k < 50; ++k) {
    const hand::HandPose pose = randomPose(*problem.model, random);
    const Terms found = objective.evaluate(pose);
    const Terms expected = directTerms(problem, pose);
    EXPECT_NEAR(found.distance, expected.distance, 1e-12 * expected.distance);
    // A sum over the moments is exact to the rounding of its largest part, which is one a pair.
    const double rounding = 1e-14 * static_cast<double>(problem.pairs.size());
    EXPECT_NEAR(found.normal, expected.normal, 1e-12 * expected.normal + rounding);
    EXPECT_NEAR(found.prior, expected.prior, 1e-12 * expected.prior);
    EXPECT_NEAR(found.objective, expected.objective, 1e-12 * expected.objective + rounding);
  }
}

/// One pair on the root, at the origin, its normals opposed.
PoseProblem onePair() {
  PoseProblem problem = makeProblem(test::rigidHand());
  problem.weights = {1.0, 1.0, 1.0};
  PointPair pair;
  pair.n_L = Eigen::Vector3d::UnitZ();
  pair.n_W = -Eigen::Vector3d::UnitZ();
  problem.pairs.push_back(pair);
  return problem;
}

hand::HandPose turned(const Eigen::Vector3d& w) {
  hand::HandPose pose;
  pose.X_WH.linear() = rotationFromVector(w);
  pose.q.resize(0);
  return pose;
}

TEST(Objective, SumsAreThoseOfThePaperPairByPair) {
  std::mt19937 random(1);
  expectTermsMatch(randomProblem(test::syntheticHand(), 200, random), random);
  expectTermsMatch(randomProblem(test::rigidHand(), 1, random), random);
}

TEST(Objective, GradientMatchesCentralDifferencesOnEveryKindOfJoint) {
  std::mt19937 random(2);
  expectGradientMatches(randomProblem(test::syntheticHand(), 60, random), random, 50);
  expectGradientMatches(randomProblem(test::rigidHand(), 7, random), random, 20);
}

TEST(Objective, PairsWithoutNormalsCountForTheDistanceAlone) {
  std::mt19937 random(12);
  for (const NormalForm form : {NormalForm::kCosine, NormalForm::kSum}) {
    PoseProblem problem = randomProblem(test::syntheticHand(), 40, random);
    problem.normal_form = form;
    for (std::size_t i = 0; i < problem.pairs.size(); i += 3)
      problem.pairs[i].has_normals = false;
    expectGradientMatches(problem, random, 10);
    const hand::HandPose pose = randomPose(*problem.model, random);
    const Terms found = Objective(problem).evaluate(pose);
    PoseProblem other = problem;
    for (std::size_t i = 0; i < problem.pairs.size(); i += 3)
      other.pairs[i].n_W = -other.pairs[i].n_W;
    EXPECT_EQ(Objective(other).evaluate(pose).objective, found.objective);
    if (form == NormalForm::kCosine) expectTermsMatch(problem, random);
  }
}

TEST(Objective, GradientMatchesCentralDifferencesOnRealHands) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(3);
  for (const std::string& file : test::realHands()) {
    const auto model =
        std::make_shared<const hand::HandModel>(io::readUrdfKinematics(test::sharedData(file)));
    expectGradientMatches(randomProblem(model, 100, random), random, 10);
    expectTermsMatch(randomProblem(model, 100, random), random);
  }
}

TEST(Objective, GradientIsTheSameWithAndWithoutMoments) {
  // Splitting a pair into two of half the weight changes the moments' sums, not the function.
  std::mt19937 random(4);
  PoseProblem whole = randomProblem(test::syntheticHand(), 10, random);
  PoseProblem halves = whole;
  halves.pairs.clear();
  for (PointPair pair : whole.pairs) {
    pair.weight *= 0.5;
    halves.pairs.push_back(pair);
    halves.pairs.push_back(pair);
  }
  const hand::HandPose pose = randomPose(*whole.model, random);
  Eigen::VectorXd a;
  Eigen::VectorXd b;
  Objective(whole).evaluate(pose, a);
  Objective(halves).evaluate(pose, b);
  EXPECT_LE((a - b).norm(), 1e-12 * a.norm());
}

TEST(Objective, IsUnchangedWhenTheWorldIsMoved) {
  std::mt19937 random(5);
  PoseProblem problem = randomProblem(test::syntheticHand(), 40, random);
  problem.prior_weights.resize(0);
  hand::HandPose pose = randomPose(*problem.model, random);
  const Terms before = Objective(problem).evaluate(pose);

  const Pose X_VW = randomPose(*problem.model, random).X_WH;
  for (PointPair& pair : problem.pairs) {
    pair.p_W = X_VW * pair.p_W;
    pair.n_W = X_VW.linear() * pair.n_W;
  }
  problem.prior.X_WH = X_VW * problem.prior.X_WH;
  pose.X_WH = X_VW * pose.X_WH;
  const Terms after = Objective(problem).evaluate(pose);

  EXPECT_NEAR(after.distance, before.distance, 1e-12 * before.distance);
  EXPECT_NEAR(after.normal, before.normal, 1e-12 * before.normal);
  EXPECT_NEAR(after.prior, before.prior, 1e-12 * before.prior);
}

TEST(Objective, NormalTermIsQuarticNearAlignment) {
  const PoseProblem problem = onePair();
  Objective objective(problem);
  for (const double angle : {0.2, 0.1, 0.05}) {
    const double term = objective.evaluate(turned({angle, 0.0, 0.0})).normal;
    const double exact = std::pow(1.0 - std::cos(angle), 2);
    EXPECT_NEAR(term, exact, 1e-15);
    EXPECT_NEAR(term / (std::pow(angle, 4) / 4.0), 1.0, angle * angle);
  }
}

TEST(Objective, NormalTermIsFourAndFlatWhereTheHandIsFlipped) {
  const PoseProblem problem = onePair();
  Eigen::VectorXd gradient;
  const Terms terms =
      Objective(problem).evaluate(turned({std::numbers::pi, 0.0, 0.0}), gradient);
  EXPECT_NEAR(terms.normal, 4.0, 1e-14);
  // What is left is the prior's pull, 2 pi about x.
  EXPECT_NEAR(std::abs(gradient[0]), 2.0 * std::numbers::pi, 1e-9);
  EXPECT_NEAR(gradient.segment<2>(1).norm(), 0.0, 1e-9);
}

TEST(Objective, PriorOfTheRotationIsTheGeodesicAngleAndDoesNotWrap) {
  PoseProblem problem = onePair();
  problem.weights = {0.0, 0.0, 1.0};
  problem.prior.X_WH.linear() = rotationFromVector({0.0, 0.0, 3.0});
  Objective objective(problem);
  // 3.0 and -3.0 about the same axis are 2 pi - 6 apart, not 6.
  const double apart = 2.0 * std::numbers::pi - 6.0;
  EXPECT_NEAR(objective.evaluate(turned({0.0, 0.0, -3.0})).prior, apart * apart, 1e-12);
}

TEST(Objective, PriorGradientHoldsUpToAHalfTurn) {
  PoseProblem problem = onePair();
  problem.weights = {0.0, 0.0, 1.0};
  std::mt19937 random(6);
  for (const double angle : {1e-9, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-3}) {
    const Eigen::Vector3d axis = test::randomUnit(random);
    Objective objective(problem);
    Eigen::VectorXd gradient;
    objective.evaluate(turned(angle * axis), gradient);
    // The angle grows fastest about its own axis, at rate one.
    EXPECT_LE((gradient.head<3>() - 2.0 * angle * axis).norm(), 1e-9) << angle;
  }
}

TEST(Objective, GaussNewtonIsTheHessianWhereEveryResidualIsZero) {
  std::mt19937 random(7);
  const auto model = test::syntheticHand();
  const hand::HandPose goal = randomPose(*model, random);
  const PoseProblem problem = test::reachableProblem(model, goal, 5, random);
  Objective objective(problem);
  const Eigen::MatrixXd H = objective.gaussNewton(goal);
  constexpr double kStep = 1e-5;
  Eigen::VectorXd above;
  Eigen::VectorXd below;
  for (int i = 0; i < problem.dofCount(); ++i) {
    objective.evaluate(moved(goal, i, kStep), above);
    objective.evaluate(moved(goal, i, -kStep), below);
    EXPECT_LE(((above - below) / (2.0 * kStep) - H.col(i)).norm(), 1e-4 * H.norm()) << i;
  }
}

TEST(Objective, PairsOfNoWeightChangeNothing) {
  std::mt19937 random(8);
  PoseProblem problem = randomProblem(test::syntheticHand(), 10, random);
  const hand::HandPose pose = randomPose(*problem.model, random);
  const double before = Objective(problem).evaluate(pose).objective;
  PointPair extra = problem.pairs.front();
  extra.weight = 0.0;
  extra.p_W.setConstant(5.0);
  problem.pairs.push_back(extra);
  EXPECT_EQ(Objective(problem).evaluate(pose).objective, before);
}

TEST(Objective, RefusesPairsOnNoLink) {
  PoseProblem problem = onePair();
  problem.pairs[0].link = 1;
  EXPECT_THROW(Objective{problem}, BrokenContract);
}

}  // namespace
}  // namespace handgraft::optimize
