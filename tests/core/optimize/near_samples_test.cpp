#include "core/optimize/near_samples.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/hand/hand_solid.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.02;  // m, of the ball whose samples move

/// Even samples of a ball.
hand::SampleSet samplesOfABall() {
  const geometry::TriangleMesh ball = geometry::makeSphere(kRadius, 4);
  const Eigen::Matrix3Xd& points = ball.vertices();
  std::vector<int> order;
  for (int i = 0; i < points.cols(); ++i)
    order.push_back(i);
  hand::SampleSet set;
  set.tree_L = geometry::BallTree(points, order);
  for (const int i : order)
    set.samples.push_back({points.col(i), 1e-6 * i});
  return set;
}

geometry::DistanceGrid gridOf(const geometry::TriangleMesh& mesh) {
  geometry::DistanceGridOptions options;
  options.most_nodes = 30000;
  return {std::make_shared<const geometry::SignedDistance>(mesh), options, Progress()};
}

/// A way of small steps, of leaps, and of small ones again.
Pose stepFrom(const Pose& X_BA, int step, std::mt19937& random) {
  const bool leaps = step % 20 == 0;
  const double length = leaps ? 0.02 : 0.0004 * (step % 7);
  Pose next = X_BA;
  next.linear() = rotationFromVector(10.0 * length * test::randomUnit(random)) * X_BA.linear();
  next.translation() += length * test::randomUnit(random);
  if (next.translation().norm() > 0.06) next.translation() *= 0.8;
  return next;
}

TEST(NearSamples, FindsWhatLookingAtEverySampleFinds) {
  const hand::SampleSet set = samplesOfABall();
  for (const geometry::TriangleMesh& mesh :
       {geometry::makeSphere(0.03, 4), geometry::makeBox({0.08, 0.003, 0.06})}) {
    const geometry::DistanceGrid grid_B = gridOf(mesh);
    for (const double threshold : {0.0004, -0.0005}) {
      std::mt19937 random(7);
      NearSamples near;
      Pose X_BA = Pose::Identity();
      X_BA.translation() = Vector3d(0.04, 0.0, 0.0);
      int found = 0;
      int gathered = 0;
      for (int step = 1; step <= 400; ++step) {
        X_BA = stepFrom(X_BA, step, random);
        std::vector<double> expected;
        for (const hand::SurfaceSample& sample : set.samples)
          if (grid_B.at(X_BA * sample.p_L) < threshold) expected.push_back(sample.area_m2);
        std::vector<double> seen;
        near.visit(
            {grid_B, threshold, Vector3d::Zero(), kRadius}, X_BA,
            [&](const auto& passes, const auto& take) {
              ++gathered;
              set.visit(passes, [&](const hand::SurfaceSample& sample) {
                take(sample.p_L, sample.area_m2);
              });
            },
            [&](const NearSamples::Sample& sample, const Vector3d& p_B, double distance,
                const Vector3d& slope_B) {
              seen.push_back(sample.area_m2);
              EXPECT_LT((p_B - X_BA * sample.p_A).norm(), 1e-15);
              EXPECT_EQ(distance, grid_B.at(p_B));
              EXPECT_NEAR(slope_B.norm(), 1.0, 1.0);
            });
        EXPECT_EQ(seen, expected) << "step " << step;
        found += static_cast<int>(seen.size());
      }
      EXPECT_GT(found, 1000);
      EXPECT_LT(gathered, 300);
    }
  }
}

TEST(NearSamples, ForgetsWhenTold) {
  const hand::SampleSet set = samplesOfABall();
  const geometry::DistanceGrid grid_B = gridOf(geometry::makeSphere(0.03, 4));
  NearSamples near;
  Pose X_BA = Pose::Identity();
  X_BA.translation() = Vector3d(0.045, 0.0, 0.0);
  const auto count_with = [&](bool any) {
    int count = 0;
    near.visit(
        {grid_B, 0.0, Vector3d::Zero(), kRadius}, X_BA,
        [&](const auto& passes, const auto& take) {
          if (!any) return;
          set.visit(passes, [&](const hand::SurfaceSample& sample) {
            take(sample.p_L, sample.area_m2);
          });
        },
        [&](const NearSamples::Sample&, const Vector3d&, double, const Vector3d&) {
          ++count;
        });
    return count;
  };
  const int all = count_with(true);
  EXPECT_GT(all, 0);
  EXPECT_EQ(count_with(false), all);  // the list is kept
  near.forget();
  EXPECT_EQ(count_with(false), 0);  // other samples, as of another set
}

TEST(NearSamples, MotionBoundsEveryPointOfTheBall) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(0.0, 3.1);
  for (int k = 0; k < 1000; ++k) {
    Pose from = Pose::Identity();
    Pose to = Pose::Identity();
    from.linear() = rotationFromVector(angle(random) * test::randomUnit(random));
    to.linear() = rotationFromVector(angle(random) * test::randomUnit(random));
    to.translation() = 0.01 * test::randomUnit(random);
    const Vector3d centre = 0.1 * test::randomUnit(random);
    const Vector3d p = centre + 0.03 * test::randomUnit(random);
    EXPECT_LE((to * p - from * p).norm(), motionOf(from, to, centre, 0.03) + 1e-12);
  }
}

}  // namespace
}  // namespace handgraft::optimize
