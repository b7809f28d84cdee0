// Meshes that fuzzing found, told in words.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/geometry/log_map.h"

namespace handgraft::geometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A sphere with one vertex so far out that the squares of its lengths overflow.
TriangleMesh sphereWithASpike(int spike) {
  const TriangleMesh sphere = makeSphere(0.05, 2);
  Eigen::Matrix3Xd vertices = sphere.vertices();
  vertices.col(spike) = Eigen::Vector3d(1e243, -3e242, 0.5);
  return {vertices, sphere.faces()};
}

TEST(LogMap, LeavesOutWhatOnlyOverflowingWaysReach) {
  constexpr int kSpike = 40;
  const TriangleMesh mesh = sphereWithASpike(kSpike);
  for (const LogMapMethod method :
       {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto}) {
    SCOPED_TRACE(nameOf(method));
    const LogMap map = computeLogMap(mesh, surfacePointAtVertex(mesh, 3),
                                     Eigen::Vector3d(0.3, 0.5, -0.4), kInfinity, method);
    EXPECT_GT(map.vertices.size(), 100u);
    for (const int v : map.vertices) {
      ASSERT_TRUE(std::isfinite(map.r[v])) << v;
      ASSERT_TRUE(std::isfinite(map.phi[v])) << v;
    }
    const LogMapInverse inverse(mesh, map);
    const LogMapInverse::Place place = inverse.at({0.01, 0.02});
    ASSERT_TRUE(place.point.valid());
    EXPECT_LT((positionOf(mesh, place.point) - mesh.vertex(3)).norm(), 0.03);
  }
}

}  // namespace
}  // namespace handgraft::geometry
