// The moments against the same sums taken point by point.

#include <cmath>

#include <gtest/gtest.h>

#include "core/io/urdf_file.h"
#include "core/optimize/objective.h"

#include "tests/core/optimize/problems.h"
#include "tests/support/shared_data.h"

namespace handgraft::optimize {
namespace {

using test::moved;
using test::randomPose;
using test::randomProblem;

/// Eq. 3 and 4 point by point, with derivatives by hand::pointJacobian; and for each entry the
/// sum of the magnitudes of its terms, which is what rounding is a share of.
struct PointSums {
  double value = 0.0;
  double value_magnitude = 0.0;
  Eigen::VectorXd gradient;
  Eigen::VectorXd gradient_magnitude;
  Eigen::MatrixXd gauss_newton;
  Eigen::MatrixXd gauss_newton_magnitude;
};

/// Adds scale * r^2 of one residual with derivative `J`; `parts` bounds what r was made from.
void addResidual(
    double scale, double r, double parts, const Eigen::RowVectorXd& J, PointSums& sums) {
  const Eigen::VectorXd size = J.cwiseAbs().transpose();
  sums.value += scale * r * r;
  sums.value_magnitude += scale * parts * parts;
  sums.gradient += 2.0 * scale * r * J.transpose();
  sums.gradient_magnitude += 2.0 * scale * parts * size;
  sums.gauss_newton += 2.0 * scale * J.transpose() * J;
  sums.gauss_newton_magnitude += 2.0 * scale * size * size.transpose();
}

/// 3 x dofs: derivative of R a by all degrees of freedom, a fixed to the link.
Eigen::MatrixXd directionJacobian(const Eigen::Matrix<double, 6, Eigen::Dynamic>& J,
                                  const Eigen::Vector3d& a_W) {
  return -crossMatrix(a_W) * J.topRows<3>();
}

PointSums sumPoints(const PoseProblem& problem, const hand::HandPose& pose) {
  const int dofs = problem.dofCount();
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, pose);
  PointSums sums;
  sums.gradient = sums.gradient_magnitude = Eigen::VectorXd::Zero(dofs);
  sums.gauss_newton = sums.gauss_newton_magnitude = Eigen::MatrixXd::Zero(dofs, dofs);
  for (const PointPair& pair : problem.pairs) {
    const Pose& X = X_WL[static_cast<std::size_t>(pair.link)];
    const Eigen::Vector3d p_W = X * pair.p_L;
    const Eigen::Vector3d m_W = X.linear() * pair.n_L;
    Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, dofs);
    J.leftCols<6>().setIdentity();
    J.block<3, 3>(3, 0) = -crossMatrix(p_W - pose.X_WH.translation());
    J.rightCols(dofs - 6) = pointJacobian(*problem.model, X_WL, pair.link, p_W);
    const Eigen::MatrixXd jacobian_m = directionJacobian(J, m_W);
    const double d = problem.weights.distance * pair.weight;
    const double n = problem.weights.normal * pair.weight;
    for (int i = 0; i < 3; ++i) {
      const double parts = std::abs(p_W[i]) + std::abs(pair.p_W[i]) + 0.1;
      addResidual(d, p_W[i] - pair.p_W[i], parts, J.row(3 + i), sums);
      if (problem.normal_form == NormalForm::kSum) {
        addResidual(n, m_W[i] + pair.n_W[i], 2.0, jacobian_m.row(i), sums);
      }
    }
    if (problem.normal_form == NormalForm::kCosine) {
      addResidual(n, 1.0 + m_W.dot(pair.n_W), 2.0, pair.n_W.transpose() * jacobian_m, sums);
    }
  }
  return sums;
}

void expectMomentsEqualPoints(PoseProblem problem, std::mt19937& random) {
  problem.weights.prior = 0.0;
  QuadraticModel model(problem.dofCount());
  for (const NormalForm form : {NormalForm::kCosine, NormalForm::kSum}) {
    problem.normal_form = form;
    Objective objective(problem);
    for (int k = 0; k < 20; ++k) {
      const hand::HandPose pose = randomPose(*problem.model, random);
      const PointSums points = sumPoints(problem, pose);
      const double value = objective.evaluate(pose).objective;
      objective.expand(model);
      EXPECT_LE(std::abs(value - points.value), 1e-12 * points.value_magnitude);
      EXPECT_TRUE(((model.gradient - points.gradient).array().abs() <=
                   1e-12 * points.gradient_magnitude.array() + 1e-300)
                      .all())
          << (model.gradient - points.gradient).transpose();
      EXPECT_TRUE(((model.gauss_newton - points.gauss_newton).array().abs() <=
                   1e-12 * points.gauss_newton_magnitude.maxCoeff())
                      .all());
    }
  }
}

void expectHessianMatchesDifferences(const PoseProblem& problem, std::mt19937& random) {
  Objective objective(problem);
  QuadraticModel model(problem.dofCount());
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 10; ++k) {
    const hand::HandPose pose = randomPose(*problem.model, random);
    const double value = objective.evaluate(pose).objective;
    objective.expand(model);
    const Eigen::MatrixXd H = model.gauss_newton + model.residual_curvature;
    // Along each coordinate the second difference of the value itself: the gradient's own frame
    // turns with the root.
    for (int i = 0; i < problem.dofCount(); ++i) {
      const double second = (objective.evaluate(moved(pose, i, kStep)).objective - 2.0 * value +
                             objective.evaluate(moved(pose, i, -kStep)).objective) /
                            (kStep * kStep);
      EXPECT_NEAR(H(i, i), second, 1e-5 * H.norm()) << i;
    }
    // Across: joints move nobody's frame, so the gradient's change is the column.
    Eigen::VectorXd above;
    Eigen::VectorXd below;
    for (int j = 3; j < problem.dofCount(); ++j) {
      objective.evaluate(moved(pose, j, kStep), above);
      objective.evaluate(moved(pose, j, -kStep), below);
      EXPECT_LE(((above - below) / (2.0 * kStep) - H.col(j)).norm(), 1e-6 * H.norm()) << j;
    }
    EXPECT_LE((H - H.transpose()).norm(), 1e-12 * H.norm());
  }
}

TEST(MomentForm, EqualsTheSumOverPoints) {
  std::mt19937 random(31);
  expectMomentsEqualPoints(randomProblem(test::syntheticHand(), 300, random), random);
  expectMomentsEqualPoints(randomProblem(test::rigidHand(), 1, random), random);
}

TEST(MomentForm, EqualsTheSumOverPointsOnRealHands) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(32);
  for (const std::string& file : test::realHands()) {
    SCOPED_TRACE(file);
    const auto model =
        std::make_shared<const hand::HandModel>(io::readUrdfKinematics(test::sharedData(file)));
    expectMomentsEqualPoints(randomProblem(model, 100, random), random);
  }
}

TEST(MomentForm, KeepsTheDigitsOfAPerfectFitFarFromTheOrigin) {
  std::mt19937 random(33);
  const auto model = test::syntheticHand();
  hand::HandPose goal = randomPose(*model, random);
  goal.X_WH.translation() += Eigen::Vector3d::Constant(10.0);
  const PoseProblem problem = test::reachableProblem(model, goal, 5, random);
  Objective objective(problem);
  const Terms terms = objective.evaluate(goal);
  EXPECT_GE(terms.distance, 0.0);
  EXPECT_LE(terms.distance, 1e-15);  // m^2 of 35 pairs; spreads of 2 cm, places of 10 m
  EXPECT_GE(terms.normal, 0.0);
  EXPECT_LE(terms.normal, 1e-13);
}

TEST(QuadraticModel, HessianMatchesDifferencesOnEveryKindOfJoint) {
  std::mt19937 random(34);
  PoseProblem problem = randomProblem(test::syntheticHand(), 60, random);
  expectHessianMatchesDifferences(problem, random);
  problem.normal_form = NormalForm::kSum;
  expectHessianMatchesDifferences(problem, random);
  // Without points the curvature of the prior's angle is all there is.
  problem.pairs.clear();
  expectHessianMatchesDifferences(problem, random);
}

TEST(QuadraticModel, HessianMatchesDifferencesOnHandsWithMimicJoints) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(35);
  for (const std::string& file : test::realHands()) {
    SCOPED_TRACE(file);
    const auto model =
        std::make_shared<const hand::HandModel>(io::readUrdfKinematics(test::sharedData(file)));
    expectHessianMatchesDifferences(randomProblem(model, 50, random), random);
  }
}

TEST(MomentTree, HoldsOneBodyForLinksFixedToEachOtherAndNoneWithoutPairs) {
  std::mt19937 random(36);
  PoseProblem problem = randomProblem(test::syntheticHand(), 200, random);
  // palm, both of finger a (its tip is fixed to the distal link), three of finger b.
  EXPECT_EQ(makeMomentTree(problem).bodyCount(), 6);
  for (PointPair& pair : problem.pairs)
    pair.link = problem.model->linkIndex("a_tip");
  const MomentTree tree = makeMomentTree(problem);
  EXPECT_EQ(tree.bodyCount(), 3);
  EXPECT_EQ(tree.moments.size(), 1U);
}

}  // namespace
}  // namespace handgraft::optimize
