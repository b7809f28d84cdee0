#include "core/contact/threshold.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

/// Numbers without order that are the same everywhere.
Eigen::VectorXd noise(Eigen::Index count) {
  Eigen::VectorXd values(count);
  unsigned state = 7;
  for (Eigen::Index i = 0; i < count; ++i) {
    state = state * 1664525U + 1013904223U;
    values[i] = static_cast<double>(state >> 8U) / static_cast<double>(1U << 24U);
  }
  return values;
}

/// Otsu's measure by its other definition: the smallest sum of the variances within.
double varianceWithin(const Eigen::VectorXd& v, const Eigen::VectorXd& w, double threshold) {
  double within = 0.0;
  for (const bool above : {false, true}) {
    double weight = 0.0;
    double sum = 0.0;
    double squares = 0.0;
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      if ((v[i] > threshold) != above) continue;
      weight += w[i];
      sum += w[i] * v[i];
      squares += w[i] * v[i] * v[i];
    }
    if (weight > 0.0) within += squares - sum * sum / weight;
  }
  return within;
}

TEST(OtsuThreshold, LeavesTheLeastVarianceWithinTheClasses) {
  const Eigen::VectorXd v = noise(200).array().square();
  const Eigen::VectorXd w = noise(400).tail(200);
  const double threshold = otsuThreshold(v, w);
  const double best = varianceWithin(v, w, threshold);
  for (Eigen::Index i = 0; i < v.size(); ++i)
    EXPECT_LE(best, varianceWithin(v, w, v[i]) + 1e-12);
}

TEST(OtsuThreshold, LiesHalfwayBetweenTwoClusters) {
  const Eigen::VectorXd v = (Eigen::VectorXd(5) << 0.1, 0.9, 0.2, 1.0, 0.15).finished();
  EXPECT_DOUBLE_EQ(otsuThreshold(v, Eigen::VectorXd::Ones(5)), 0.55);
}

TEST(OtsuThreshold, CountsByWeight) {
  const Eigen::VectorXd v = noise(50);
  Eigen::VectorXd w = Eigen::VectorXd::Ones(50);
  Eigen::VectorXd twice(51);
  twice << v, v[7];
  w[7] = 2.0;
  EXPECT_DOUBLE_EQ(otsuThreshold(v, w), otsuThreshold(twice, Eigen::VectorXd::Ones(51)));
  Eigen::VectorXd more(51);
  more << v, 100.0;
  Eigen::VectorXd none = Eigen::VectorXd::Ones(51);
  none[50] = 0.0;
  EXPECT_DOUBLE_EQ(otsuThreshold(v, Eigen::VectorXd::Ones(50)), otsuThreshold(more, none));
}

TEST(OtsuThreshold, RefusesWhatHasNoTwoClasses) {
  EXPECT_THROW(otsuThreshold(Eigen::VectorXd::Ones(4), Eigen::VectorXd::Ones(4)), InvalidInput);
  EXPECT_THROW(otsuThreshold(noise(4), Eigen::VectorXd::Zero(4)), InvalidInput);
  EXPECT_THROW(otsuThreshold({}, {}), InvalidInput);
}

TEST(VertexAreas, SumUpToTheSurface) {
  const TriangleMesh box = geometry::makeBox({1, 2, 3});
  EXPECT_NEAR(vertexAreas(box).sum(), box.area(), 1e-12);
}

TEST(AboveWithHysteresis, KeepsWhatHangsTogetherWithTheStrong) {
  // A ridge along the middle row of a plate falls from 1 to 0.3; another one stays at 0.5.
  const TriangleMesh plate = test::makePlate(10, 10, 0.001);
  Eigen::VectorXd value = Eigen::VectorXd::Zero(plate.vertexCount());
  for (int i = 0; i <= 10; ++i) {
    value[5 * 11 + i] = 1.0 - 0.07 * i;
    value[9 * 11 + i] = 0.5;
  }
  const std::vector<char> all(static_cast<std::size_t>(plate.vertexCount()), 1);
  const auto kept = aboveWithHysteresis(plate, value, all, 0.4, 0.8);
  EXPECT_EQ(std::accumulate(kept.begin(), kept.end(), 0), 9);  // 1.00 to 0.44
  const auto strong = aboveWithHysteresis(plate, value, all, 0.8, 0.8);
  EXPECT_EQ(std::accumulate(strong.begin(), strong.end(), 0), 3);  // 1.00, 0.93, 0.86
  // Not through vertices that are no candidates.
  std::vector<char> cut = all;
  cut[5 * 11 + 4] = 0;
  const auto before = aboveWithHysteresis(plate, value, cut, 0.4, 0.8);
  EXPECT_EQ(std::accumulate(before.begin(), before.end(), 0), 4);
}

TEST(Smoothed, KeepsTheIntegralTheRangeAndConstants) {
  const TriangleMesh ball = geometry::makeSphere(0.03, 3);
  const Eigen::VectorXd value = noise(ball.vertexCount());
  const Eigen::VectorXd areas = vertexAreas(ball);
  const Eigen::VectorXd even = smoothed(ball, value, 8);
  EXPECT_NEAR(even.dot(areas), value.dot(areas), 1e-12 * areas.sum());
  EXPECT_GE(even.minCoeff(), value.minCoeff());
  EXPECT_LE(even.maxCoeff(), value.maxCoeff());
  EXPECT_LT((even.array() - 0.5).square().mean(), 0.05 * (value.array() - 0.5).square().mean());
  const Eigen::VectorXd constant = Eigen::VectorXd::Constant(ball.vertexCount(), 0.7);
  EXPECT_LT((smoothed(ball, constant, 5) - constant).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Smoothed, TakesPermittedStepsAlone) {
  const TriangleMesh plate = test::makePlate(2, 2, 0.001);
  const Eigen::VectorXd value = noise(9);
  EXPECT_EQ(smoothed(plate, value, 0), value);
  EXPECT_THROW(smoothed(plate, value, -1), InvalidInput);
  EXPECT_THROW(smoothed(plate, value, kMostSmoothingSteps + 1), InvalidInput);
}

}  // namespace
}  // namespace handgraft::contact
