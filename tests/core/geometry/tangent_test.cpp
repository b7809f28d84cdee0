#include "core/geometry/tangent.h"

#include <cmath>

#include <gtest/gtest.h>

namespace handgraft::geometry {
namespace {

const SurfacePoint somewhere{7, {0.5, 0.2, 0.3}};

TEST(TangentAt, LiesInTheTangentPlaneNearestToTheDirection) {
  const TriangleMesh ball = geometry::makeSphere(0.03, 2);
  const Eigen::Vector3d n = normalOf(ball, somewhere);
  const Eigen::Vector3d d(3, -1, 2);
  const auto tangent = tangentAt(ball, somewhere, d);
  ASSERT_TRUE(tangent.has_value());
  EXPECT_NEAR(tangent->norm(), 1.0, 1e-12);
  EXPECT_NEAR(tangent->dot(n), 0.0, 1e-12);
  EXPECT_NEAR(tangent->dot(d.cross(n)), 0.0, 1e-12);
  EXPECT_GT(tangent->dot(d), 0.0);
}

TEST(TangentAt, IsMissingAlongTheNormal) {
  const TriangleMesh ball = geometry::makeSphere(0.03, 2);
  EXPECT_FALSE(tangentAt(ball, somewhere, -2.0 * normalOf(ball, somewhere)).has_value());
  EXPECT_FALSE(tangentAt(ball, somewhere, Eigen::Vector3d::Zero()).has_value());
}

TEST(TangentCarried, KeepsTheAngleOnAPlaneAndTurnsOverAnEdge) {
  const TriangleMesh box = geometry::makeBox({1, 1, 1});
  SurfacePoint on_top;
  SurfacePoint on_side;
  for (int f = 0; f < box.faceCount(); ++f) {
    const SurfacePoint middle{f, Eigen::Vector3d::Constant(1.0 / 3.0)};
    if (box.faceNormals().col(f).z() > 0.9) on_top = middle;
    if (box.faceNormals().col(f).x() > 0.9) on_side = middle;
  }
  ASSERT_TRUE(on_top.valid() && on_side.valid());
  const Eigen::Vector3d carried =
      tangentCarried(box, on_top, on_side, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(carried.dot(normalOf(box, on_side)), 0.0, 1e-12);
  EXPECT_LT(carried.z(), 0.0);
}

TEST(TangentTurned, TurnsLeftSeenFromOutside) {
  const TriangleMesh ball = makeSphere(0.03, 2);
  const Eigen::Vector3d n = normalOf(ball, somewhere);
  const Eigen::Vector3d d = anyTangentAt(ball, somewhere);
  const Eigen::Vector3d turned = tangentTurned(ball, somewhere, d, 0.3);
  EXPECT_LT((turned - std::cos(0.3) * d - std::sin(0.3) * n.cross(d)).norm(), 1e-14);
}

}  // namespace
}  // namespace handgraft::geometry
