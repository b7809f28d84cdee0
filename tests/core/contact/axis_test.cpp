#include "core/contact/axis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::positionOf;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

/// A plate of 120 x 60 mm.
TriangleMesh plate() {
  return test::makePlate(60, 30, 0.002);
}

using Curve = std::function<Eigen::Vector2d(double along, double across)>;

/// The outline of [0, length] x [-width / 2, width / 2] taken along by `curve`, its root at
/// `root` along, on a flat mesh.
Patch strip(
    const TriangleMesh& mesh, double length, double width, double root, const Curve& curve) {
  const geometry::SurfaceLocator locator(mesh);
  const auto at = [&](double along, double across) {
    const Eigen::Vector2d p = curve(along, across);
    return locator.nearest({p.x(), p.y(), 0.0}).point;
  };
  Patch patch;
  patch.name = "index";
  patch.root = at(root, 0.0);
  constexpr int kAlong = 16;
  for (int k = 0; k < kAlong; ++k)
    patch.interpolation_boundary.push_back(at(length * k / kAlong, -0.5 * width));
  for (int k = 0; k < 4; ++k)
    patch.interpolation_boundary.push_back(at(length, (k / 4.0 - 0.5) * width));
  for (int k = kAlong; k > 0; --k)
    patch.interpolation_boundary.push_back(at(length * k / kAlong, 0.5 * width));
  for (int k = 4; k > 0; --k)
    patch.interpolation_boundary.push_back(at(0.0, (k / 4.0 - 0.5) * width));
  return patch;
}

Eigen::Vector2d slanted(double along, double across) {
  return Eigen::Rotation2Dd(0.3) * Eigen::Vector2d(along - 0.04, across);
}

TEST(PatchShape, MeasuresARectangleOnAPlane) {
  const TriangleMesh mesh = plate();
  const PatchShape shape = shapeOf(mesh, strip(mesh, 0.08, 0.015, 0.03, slanted));
  EXPECT_NEAR(shape.length_m, 0.08, 1e-9);
  EXPECT_NEAR(shape.width_m, 0.015, 1e-9);
  EXPECT_LT((shape.long_direction_O - Eigen::Vector3d(std::cos(0.3), std::sin(0.3), 0)).norm(),
            1e-9);
}

TEST(MakeAxis, RunsThroughTheMiddleOfAStrip) {
  const TriangleMesh mesh = plate();
  const Patch patch = strip(mesh, 0.08, 0.015, 0.03, slanted);
  Patch with_axis = patch;
  with_axis.axis = makeAxis(mesh, patch);
  ASSERT_NO_THROW(validate(mesh, with_axis));
  // Half a width from either end, the root one of them, at most a width apart.
  ASSERT_EQ(with_axis.axis.size(), 6u);
  EXPECT_EQ(rootKnotOf(mesh, with_axis), 2);
  const double along[] = {0.0075, 0.01875, 0.03, 0.0441666667, 0.0583333333, 0.0725};
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector2d expected = slanted(along[k], 0.0);
    EXPECT_LT((positionOf(mesh, with_axis.axis[k]).head<2>() - expected).norm(), 1e-9) << k;
  }
}

TEST(MakeAxis, BendsAlongABentStripAndStaysWithinAWidthOfItsBoundary) {
  const TriangleMesh mesh = plate();
  const double radius = 0.05;  // a quarter of a circle nearly
  const Patch patch = strip(mesh, 0.07, 0.014, 0.035, [&](double along, double across) {
    const double angle = (along - 0.035) / radius;
    return Eigen::Vector2d((radius + across) * std::sin(angle),
                           (radius + across) * std::cos(angle) - radius);
  });
  const auto axis = makeAxis(mesh, patch);
  ASSERT_GE(axis.size(), 5u);
  for (const SurfacePoint& knot : axis) {
    const Eigen::Vector2d p = positionOf(mesh, knot).head<2>() + Eigen::Vector2d(0, radius);
    EXPECT_NEAR(p.norm(), radius, 0.003);
  }
  const double width = shapeOf(mesh, patch).width_m;
  for (const SurfacePoint& point : patch.interpolation_boundary) {
    double nearest = 1.0;
    for (const SurfacePoint& knot : axis) {
      nearest = std::min(nearest, (positionOf(mesh, knot) - positionOf(mesh, point)).norm());
    }
    EXPECT_LT(nearest, 1.1 * width);
  }
}

TEST(MakeAxis, IsForLongPatchesAlone) {
  const TriangleMesh mesh = plate();
  EXPECT_TRUE(makeAxis(mesh, strip(mesh, 0.039, 0.01, 0.02, slanted)).empty());
  EXPECT_FALSE(makeAxis(mesh, strip(mesh, 0.041, 0.01, 0.02, slanted)).empty());
  EXPECT_TRUE(makeAxis(mesh, strip(mesh, 0.05, 0.0282, 0.025, slanted)).empty());
  EXPECT_FALSE(makeAxis(mesh, strip(mesh, 0.05, 0.0274, 0.025, slanted)).empty());
  AxisOptions shorter;
  shorter.shortest_m = 0.03;
  EXPECT_FALSE(makeAxis(mesh, strip(mesh, 0.039, 0.01, 0.02, slanted), shorter).empty());
}

TEST(MakeAxis, MovesWithTheSurface) {
  const TriangleMesh mesh = plate();
  const Patch patch = strip(mesh, 0.08, 0.015, 0.03, slanted);
  const auto axis = makeAxis(mesh, patch);
  Eigen::Affine3d X(Eigen::Translation3d(0.4, -1, 2));
  X.rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, -1).normalized()));
  const TriangleMesh moved = geometry::transformed(mesh, X);
  const auto again = makeAxis(moved, patch);
  ASSERT_EQ(again.size(), axis.size());
  for (std::size_t k = 0; k < axis.size(); ++k) {
    EXPECT_LT((positionOf(moved, again[k]) - X * positionOf(mesh, axis[k])).norm(), 1e-9) << k;
  }
}

TEST(MakeAxis, RefusesOptionsOutOfRange) {
  const TriangleMesh mesh = plate();
  const Patch patch = strip(mesh, 0.08, 0.015, 0.03, slanted);
  for (const double wrong : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    AxisOptions options;
    options.shortest_m = wrong;
    EXPECT_THROW(makeAxis(mesh, patch, options), InvalidInput);
    options = {};
    options.slenderness = wrong;
    EXPECT_THROW(makeAxis(mesh, patch, options), InvalidInput);
  }
}

}  // namespace
}  // namespace handgraft::contact
