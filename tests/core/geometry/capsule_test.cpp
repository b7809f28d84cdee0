#include "core/geometry/capsule.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace handgraft::geometry {
namespace {

using Eigen::Vector3d;

class Dice {
 public:
  Vector3d point(double size) {
    return {size * unit_(random_), size * unit_(random_), size * unit_(random_)};
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

/// By a search over both segments.
double searched(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  constexpr int kSteps = 400;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const Vector3d p = a + (b - a) * i / kSteps;
    const Vector3d way = d - c;
    const double length = way.squaredNorm();
    const double t =
        length > 0.0 ? std::min(1.0, std::max(0.0, (p - c).dot(way) / length)) : 0.0;
    least = std::min(least, (p - c - t * way).squaredNorm());
  }
  return least;
}

TEST(Segments, AreAsFarApartAsASearchFinds) {
  Dice dice;
  for (int i = 0; i < 200; ++i) {
    const Vector3d a = dice.point(1.0);
    const Vector3d b = dice.point(1.0);
    const Vector3d c = dice.point(1.0) + (i % 2 == 0 ? 2.0 : 0.0) * Vector3d::UnitX();
    const Vector3d d = i % 5 == 0 ? Vector3d(c + 0.7 * (b - a)) : dice.point(1.0);
    const double exact = std::sqrt(squaredDistance(a, b, c, d));
    const double found = std::sqrt(searched(a, b, c, d));
    EXPECT_LE(exact, found + 1e-12);
    EXPECT_NEAR(exact, found, 5e-3);
  }
}

TEST(Segments, MayBePoints) {
  const Vector3d o = Vector3d::Zero();
  const Vector3d x = Vector3d::UnitX();
  EXPECT_DOUBLE_EQ(squaredDistance(o, o, x, x), 1.0);
  EXPECT_DOUBLE_EQ(squaredDistance(o, 2.0 * x, x, x), 0.0);
  EXPECT_DOUBLE_EQ(squaredDistance(x, x, o, 2.0 * x), 0.0);
  EXPECT_DOUBLE_EQ(squaredDistance(3.0 * x, 3.0 * x, o, 2.0 * x), 1.0);
}

TEST(Capsule, HoldsAllPointsOfAFingerWithoutMuchRoom) {
  Dice dice;
  Eigen::Matrix3Xd points(3, 500);
  const Vector3d bone = Vector3d(1.0, -2.0, 0.5).normalized();
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = 0.008 * dice.point(1.0).normalized() + dice.point(0.02).x() * bone;
  const Capsule capsule = capsuleAround(points);
  EXPECT_NEAR(capsule.radius, 0.008, 5e-4);
  EXPECT_LT((capsule.b - capsule.a).norm(), 0.0405);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Vector3d p = points.col(i);
    EXPECT_LE(std::sqrt(squaredDistance(capsule.a, capsule.b, p, p)), capsule.radius + 1e-12);
  }
}

TEST(Capsule, OfAPointOrAPlateIsABall) {
  const Vector3d p(0.1, 0.2, 0.3);
  const Capsule point = capsuleAround(Eigen::Matrix3Xd(p));
  EXPECT_DOUBLE_EQ(point.radius, 0.0);
  EXPECT_EQ(point.a, p);
  EXPECT_EQ(point.b, p);
  EXPECT_DOUBLE_EQ(capsuleAround(Eigen::Matrix3Xd(3, 0)).radius, 0.0);
  Eigen::Matrix3Xd square(3, 4);
  square << 1, 1, -1, -1, 1, -1, 1, -1, 0, 0, 0, 0;
  const Capsule plate = capsuleAround(square);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Vector3d corner = square.col(i);
    EXPECT_LE(std::sqrt(squaredDistance(plate.a, plate.b, corner, corner)),
              plate.radius + 1e-12);
  }
}

}  // namespace
}  // namespace handgraft::geometry
