#include "core/base/pose.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft {
namespace {

Eigen::Vector3d randomVector(std::mt19937& generator, double length) {
  std::normal_distribution<double> normal;
  Eigen::Vector3d v(normal(generator), normal(generator), normal(generator));
  return length * v.normalized();
}

class RotationVectors : public testing::TestWithParam<double> {};

TEST_P(RotationVectors, AgreeWithEigensAngleAxis) {
  std::mt19937 generator(1);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d w = randomVector(generator, GetParam());
    Eigen::Matrix3d expected = Eigen::Matrix3d::Identity();
    if (w.norm() > 0.0) expected = Eigen::AngleAxisd(w.norm(), w.normalized()).matrix();
    EXPECT_LT((rotationFromVector(w) - expected).norm(), 1e-14) << "w = " << w.transpose();
  }
}

TEST_P(RotationVectors, ComeBackFromTheirRotation) {
  std::mt19937 generator(2);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d w = randomVector(generator, GetParam());
    const Eigen::Vector3d back = vectorFromRotation(rotationFromVector(w));
    if (GetParam() < std::numbers::pi - 1e-9) {
      EXPECT_LT((back - w).norm(), 1e-9 * std::max(1.0, w.norm())) << "w = " << w.transpose();
    } else {  // at pi and beyond the vector is another one, the rotation the same
      EXPECT_LT((rotationFromVector(back) - rotationFromVector(w)).norm(), 1e-9);
      EXPECT_LE(back.norm(), std::numbers::pi + 1e-12);
    }
  }
}

TEST_P(RotationVectors, LeftJacobianMatchesCentralDifferences) {
  std::mt19937 generator(3);
  const double h = 1e-6;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d w = randomVector(generator, GetParam());
    const Eigen::Matrix3d J = leftJacobian(w);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d dw = h * Eigen::Vector3d::Unit(k);
      const Eigen::Matrix3d delta_R =
          rotationFromVector(w + dw) * rotationFromVector(w - dw).transpose();
      const Eigen::Vector3d expected = vectorFromRotation(delta_R) / (2.0 * h);
      EXPECT_LT((J.col(k) - expected).norm(), 1e-7) << "w = " << w.transpose();
    }
    if (GetParam() < 6.0) {
      EXPECT_LT((leftJacobianInverse(w) * J - Eigen::Matrix3d::Identity()).norm(), 1e-10);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Angles,
                         RotationVectors,
                         testing::Values(0.0,
                                         1e-12,
                                         1e-6,
                                         9.9e-5,
                                         1.01e-4,
                                         5e-3,
                                         1.1e-2,
                                         0.7,
                                         2.5,
                                         std::numbers::pi - 1e-6,
                                         std::numbers::pi,
                                         4.0));

TEST(Pose, TravelsThroughItsQuaternion) {
  std::mt19937 generator(4);
  for (int i = 0; i < 50; ++i) {
    Pose X = Pose::Identity();
    X.linear() = rotationFromVector(randomVector(generator, 0.06 * i));
    X.translation() = randomVector(generator, 2.0);
    const Pose back = poseFromQuaternion(X.translation(), quaternionOf(X), "test");
    EXPECT_LT((back.matrix() - X.matrix()).norm(), 1e-14);
    EXPECT_GE(quaternionOf(X)[0], 0.0);
  }
}

TEST(Pose, RefusesWhatIsNoPoseAndNamesIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector4d unit(1, 0, 0, 0);
  EXPECT_THROW(poseFromQuaternion({nan, 0, 0}, unit, "--place"), InvalidInput);
  EXPECT_THROW(poseFromQuaternion({0, 0, 0}, {nan, 0, 0, 0}, "--place"), InvalidInput);
  EXPECT_THROW(poseFromQuaternion({0, 0, 0}, {0, 0, 0, 0}, "--place"), InvalidInput);
  try {
    poseFromQuaternion({0, 0, 0}, {2, 0, 0, 0}, "--place");
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("--place"), std::string::npos);
    EXPECT_NE(message.find("norm 2"), std::string::npos);
  }
}

TEST(CrossMatrix, IsTheCrossProduct) {
  const Eigen::Vector3d a(1, -2, 3);
  const Eigen::Vector3d b(0.3, 5, -1);
  EXPECT_LT((crossMatrix(a) * b - a.cross(b)).norm(), 1e-15);
}

}  // namespace
}  // namespace handgraft
