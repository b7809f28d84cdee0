#include "core/geometry/tangent_direction.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/log_map.h"

#include "tests/core/geometry/sheet.h"

namespace handgraft::geometry {
namespace {

constexpr double kPi = std::numbers::pi;

/// Inside a face, on an edge, at a vertex.
std::vector<SurfacePoint> placesOf(const TriangleMesh& mesh) {
  return {{mesh.faceCount() / 2 + 7, {0.2, 0.5, 0.3}},
          {mesh.faceCount() / 3 + 5, {0.0, 0.4, 0.6}},
          surfacePointAtVertex(mesh, mesh.vertexCount() / 2 + 3)};
}

TEST(TangentDirection, TurnsTheLogMapByItsAngle) {
  const TriangleMesh sphere = makeSphere(0.05, 3);
  const Eigen::Vector3d direction(0.3, 0.8, -0.4);
  for (const SurfacePoint& place : placesOf(sphere)) {
    for (const double angle : {0.3, -2.0, 3.0}) {
      const Eigen::Vector3d turned = turnedDirection(sphere, place, direction, angle);
      EXPECT_NEAR(turned.norm(), 1.0, 1e-12);
      EXPECT_NEAR(angleFromTo(sphere, place, direction, turned), angle, 1e-12);
      const LogMap before = computeLogMap(sphere, place, direction, 0.03);
      const LogMap after = computeLogMap(sphere, place, turned, 0.03);
      ASSERT_GT(before.vertices.size(), 20u);
      for (const int v : before.vertices) {
        if (before.r[v] == 0.0) continue;
        EXPECT_NEAR(std::remainder(before.phi[v] - after.phi[v] - angle, 2 * kPi), 0.0, 1e-11);
      }
    }
  }
}

TEST(TangentDirection, IsAnAngleOfThePlaneOnAPlane) {
  const test::Sheet sheet = test::makePlane();
  for (const SurfacePoint& place : placesOf(sheet.mesh)) {
    const Eigen::Vector3d turned = turnedDirection(sheet.mesh, place, {2.0, 0.0, 0.7}, kPi / 3);
    EXPECT_LT((turned - Eigen::Vector3d(0.5, std::sqrt(0.75), 0.0)).norm(), 1e-12);
  }
}

TEST(TangentDirection, SharesATurnAmongAVertexFaces) {
  // A corner of a box: three right angles make a turn, so a third of it leads from one edge to
  // the next.
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  int corner = 0;
  Eigen::Vector3d(1, 1, 1).transpose().lazyProduct(box.vertices()).maxCoeff(&corner);
  const SurfacePoint place = surfacePointAtVertex(box, corner);
  const double third = 2.0 * kPi / 3.0;
  const Eigen::Vector3d x = -Eigen::Vector3d::UnitX();
  EXPECT_LT((turnedDirection(box, place, x, third) + Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((turnedDirection(box, place, x, -third) + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(TangentDirection, RefusesTheNormal) {
  const test::Sheet sheet = test::makePlane();
  const SurfacePoint place{3, {0.2, 0.5, 0.3}};
  EXPECT_THROW(turnedDirection(sheet.mesh, place, Eigen::Vector3d::UnitZ(), 1.0), InvalidInput);
  EXPECT_THROW(angleFromTo(sheet.mesh, place, {1, 0, 0}, {0, 0, 0}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
