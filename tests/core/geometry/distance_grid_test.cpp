#include "core/geometry/distance_grid.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/geometry/solids.h"

namespace handgraft::geometry {
namespace {

using Eigen::Vector3d;
using test::makeTorus;
using test::randomIn;

DistanceGrid gridOf(const TriangleMesh& mesh, int most_nodes = 60000) {
  DistanceGridOptions options;
  options.most_nodes = most_nodes;
  return {std::make_shared<const SignedDistance>(mesh), options, Progress()};
}

TEST(DistanceGrid, IsNearTheExactDistance) {
  for (const TriangleMesh& mesh :
       {makeSphere(0.04, 4), makeTorus(0.05, 0.02, 60, 30), makeBox({0.1, 0.06, 0.03})}) {
    const DistanceGrid grid = gridOf(mesh);
    std::mt19937 random(1);
    for (int k = 0; k < 5000; ++k) {
      const Vector3d p = randomIn(0.06, random);
      const double exact = grid.exact().at(p).distance;
      const double h = grid.spacing();
      Vector3d gradient;
      const double value = grid.at(p, gradient);
      const bool in_box = !gradient.isZero();
      // A ridge or an edge is rounded by half a spacing; far away every third node counts.
      const double tolerance = (std::abs(exact) < 1.5 * h ? 0.7 : 2.0) * h;
      if (in_box) {
        EXPECT_NEAR(value, exact, tolerance) << p.transpose();
      }
      EXPECT_FALSE(grid.isClear(p, exact + 1e-9)) << p.transpose();
    }
  }
}

TEST(DistanceGrid, TellsHowFarAPlaceMayMove) {
  for (const TriangleMesh& mesh : {makeSphere(0.04, 4), makeTorus(0.05, 0.02, 60, 30),
                                   makeBox({0.1, 0.06, 0.03}), makeBox({0.12, 0.003, 0.1})}) {
    const DistanceGrid grid = gridOf(mesh);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> least(-0.002, 0.002);
    for (int k = 0; k < 20000; ++k) {
      const Vector3d p = randomIn(0.07, random);
      Vector3d gradient;
      static_cast<void>(grid.at(p, gradient));
      EXPECT_LE(gradient.norm(), DistanceGrid::kSteepest) << p.transpose();
      const double wanted = least(random);
      const double enough = std::abs(least(random));
      const double clearance = grid.clearance(p, wanted, k % 2 == 0 ? enough : 1.0);
      EXPECT_EQ(clearance > enough, grid.clearance(p, wanted, enough) > enough);
      if (clearance <= 0.0) continue;
      const Vector3d there = p + clearance * randomIn(1.0, random).normalized();
      EXPECT_GE(grid.at(there), wanted - 1e-12) << p.transpose();
    }
  }
}

TEST(DistanceGrid, BoundsTheExactDistanceFromBelow) {
  for (const TriangleMesh& mesh : {makeSphere(0.04, 4), makeTorus(0.05, 0.02, 60, 30),
                                   makeBox({0.1, 0.06, 0.03}), makeBox({0.12, 0.003, 0.1})}) {
    const DistanceGrid grid = gridOf(mesh);
    const double h = grid.spacing();
    std::mt19937 random(5);
    double lost = 0.0;
    int near = 0;
    for (int k = 0; k < 20000; ++k) {
      const Vector3d p = randomIn(0.07, random);
      const double exact = grid.exact().at(p).distance;
      const double bound = grid.atLeast(p);
      EXPECT_LE(bound, std::max(exact, 0.0) + 1e-9) << p.transpose();
      if (exact < 0.0) {
        EXPECT_LE(bound, exact + 1e-9) << p.transpose();
      }
      if (std::abs(exact) > 0.5 * h) continue;
      lost += exact - bound;
      ++near;
    }
    ASSERT_GT(near, 100);
    // So close that it is worth asking.
    EXPECT_LT(lost / near, 0.35 * h);
  }
}

TEST(DistanceGrid, IsNearlyExactOnSmoothSurfaces) {
  const DistanceGrid grid = gridOf(makeSphere(0.04, 5), 300000);
  std::mt19937 random(2);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p =
        randomIn(1.0, random).normalized() * 0.04 + randomIn(0.5 * grid.spacing(), random);
    EXPECT_NEAR(grid.at(p), p.norm() - 0.04, 6e-5);
  }
}

TEST(DistanceGrid, HasTheGradientOfItsDifferences) {
  const DistanceGrid grid = gridOf(makeTorus(0.05, 0.02, 60, 30));
  std::mt19937 random(3);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = randomIn(0.06, random);
    Vector3d gradient;
    const double value = grid.at(p, gradient);
    EXPECT_NEAR(value, grid.at(p), 1e-16);
    // A spline of second order: central differences are exact but for rounding, unless they
    // straddle the border of a piece.
    for (int a = 0; a < 3; ++a) {
      const Vector3d way = 1e-7 * Vector3d::Unit(a);
      const double difference = (grid.at(p + way) - grid.at(p - way)) / 2e-7;
      if (gradient.isZero()) continue;  // outside the box
      EXPECT_NEAR(difference, gradient[a], 2e-5) << p.transpose();
    }
  }
}

TEST(DistanceGrid, HasTheExactSign) {
  const DistanceGrid grid = gridOf(makeTorus(0.05, 0.02, 60, 30));
  std::mt19937 random(4);
  int inside = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector3d p = randomIn(0.07, random);
    const double exact = grid.exact().at(p).distance;
    if (std::abs(exact) < 0.3 * grid.spacing()) continue;
    inside += exact < 0.0 ? 1 : 0;
    EXPECT_EQ(grid.at(p) < 0.0, exact < 0.0) << p.transpose() << ", exact " << exact;
  }
  EXPECT_GT(inside, 1000);
}

TEST(DistanceGrid, BoundsTheDistanceFromBelowOutsideItsBox) {
  const DistanceGrid grid = gridOf(makeBox({0.1, 0.06, 0.03}));
  std::mt19937 random(5);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = randomIn(0.5, random);
    Vector3d gradient;
    const double value = grid.at(p, gradient);
    if (!gradient.isZero()) continue;
    EXPECT_GT(value, 0.0);
    EXPECT_LE(value, grid.exact().at(p).distance + 1e-12);
  }
}

TEST(DistanceGrid, FillsSolidsWithCells) {
  const auto volume_of = [](const DistanceGrid& grid) {
    double volume = 0.0;
    for (const DistanceGrid::Cell& cell : grid.solidCells())
      volume += cell.share * std::pow(grid.spacing(), 3);
    return volume;
  };
  const double ball = 4.0 / 3.0 * std::numbers::pi * std::pow(0.04, 3);
  EXPECT_NEAR(volume_of(gridOf(makeSphere(0.04, 4))), ball, 0.01 * ball);
  EXPECT_NEAR(volume_of(gridOf(makeBox({0.1, 0.06, 0.03}))), 1.8e-4, 0.01 * 1.8e-4);
}

TEST(DistanceGrid, KeepsToItsNodesAndStopsOnWish) {
  EXPECT_GT(gridOf(makeBox({1e-4, 1.0, 1e-4}), 1000).spacing(), 0.0);
  EXPECT_THROW(static_cast<void>(gridOf(makeBox({1, 1, 1}), 10)), InvalidInput);
  DistanceGridOptions options;
  options.least_spacing_m = 0.0;
  const auto exact = std::make_shared<const SignedDistance>(makeBox({1, 1, 1}));
  EXPECT_THROW(DistanceGrid(exact, options, Progress()), InvalidInput);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(DistanceGrid(exact, {}, progress), Cancelled);
}

}  // namespace
}  // namespace handgraft::geometry
