#include "core/geometry/log_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/geometry/sheet.h"
#include "tests/core/geometry/sphere_error.h"

namespace handgraft::geometry {
namespace {

constexpr double kEverything = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-9;

Eigen::Vector2d turned(const Eigen::Vector2d& v, double angle) {
  return Eigen::Rotation2Dd(angle) * v;
}

/// Sources of every kind: inside a face, on an edge, at an inner and at a boundary vertex.
std::vector<SurfacePoint> sourcesOf(const TriangleMesh& mesh) {
  std::vector<SurfacePoint> sources = {{mesh.faceCount() / 2 + 7, {0.2, 0.5, 0.3}},
                                       {mesh.faceCount() / 3 + 5, {0.0, 0.4, 0.6}},
                                       {0, {0.4, 0.0, 0.6}}};
  sources.push_back(surfacePointAtVertex(mesh, mesh.vertexCount() / 2 + 3));
  sources.push_back(surfacePointAtVertex(mesh, 0));
  sources.push_back(surfacePointAtVertex(mesh, 5));
  return sources;
}

void expectIdentity(const test::Sheet& sheet) {
  const Eigen::Vector3d direction(0.3, 0.8, 0.1);
  const double azimuth = std::atan2(0.8, 0.3);
  for (const SurfacePoint& source : sourcesOf(sheet.mesh)) {
    const LogMap map = computeLogMap(sheet.mesh, source, direction, kEverything);
    ASSERT_EQ(map.vertices.size(), sheet.flat.size());
    const Eigen::Vector2d origin = positionOf(sheet.mesh, source).head<2>();
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      const Eigen::Vector2d truth = turned(sheet.flat[v] - origin, -azimuth);
      ASSERT_LT((logCoordinatesAtVertex(map, v) - truth).norm(), kExact) << v;
      if (truth.norm() > 0.0) {
        ASSERT_NEAR(map.r[v], truth.norm(), kExact);
      }
    }
  }
}

TEST(LogMap, IsIdentityOnAPlane) {
  expectIdentity(test::makePlane());
}

TEST(LogMap, IsIdentityOnARegularPlane) {
  expectIdentity(test::makePlane(0.0));
}

TEST(LogMap, IsIdentityOnAPlaneOfSlivers) {
  expectIdentity(test::makePlane(0.24, 0.01));
}

TEST(LogMap, UnrollsACylinder) {
  const auto [sides, width, sheet] = test::makeTube(64, 30, 3.0, 0.2);
  for (const int source : {15 * sides + 20, 3 * sides, 20}) {
    const LogMap map = computeLogMap(sheet.mesh, surfacePointAtVertex(sheet.mesh, source),
                                     Eigen::Vector3d::UnitZ(), kEverything);
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      Eigen::Vector2d truth = sheet.flat[v] - sheet.flat[source];
      truth.x() = std::remainder(truth.x(), width);
      ASSERT_NEAR(map.r[v], truth.norm(), kExact) << v;
      if (std::abs(truth.x()) > 0.499 * width)
        continue;  // on the cut locus both ways are right
      // Seen from outside, x runs to the right when z points up: phi = 0 along z.
      ASSERT_LT((logCoordinatesAtVertex(map, v) - turned(truth, -kPi / 2)).norm(), kExact) << v;
    }
  }
}

TEST(LogMap, UnrollsAConeAwayFromItsApex) {
  constexpr int kSides = 60;
  constexpr double kSlope = 0.6;  // sine of the half angle
  const double half_side = std::asin(kSlope * std::sin(kPi / kSides));
  const test::Sheet sheet =
      test::makeSheet(kSides, 20, 2.0 * kPi, 1.0, 0.0, true, [&](const Eigen::Vector2d& p) {
        const double s = 0.5 + p.y();
        return Eigen::Vector3d(s * kSlope * std::cos(p.x()), s * kSlope * std::sin(p.x()),
                               -s * std::sqrt(1.0 - kSlope * kSlope));
      });
  const int source = 8 * kSides;
  const LogMap map = computeLogMap(
      sheet.mesh, surfacePointAtVertex(sheet.mesh, source),
      -positionOf(sheet.mesh, surfacePointAtVertex(sheet.mesh, source)), kEverything);
  const auto unrolled = [&](int v) {
    const double angle =
        std::remainder(sheet.flat[v].x(), 2.0 * kPi) / (2.0 * kPi) * kSides * 2.0 * half_side;
    return Eigen::Vector2d((0.5 + sheet.flat[v].y()) * std::cos(angle),
                           (0.5 + sheet.flat[v].y()) * std::sin(angle));
  };
  int compared = 0;
  for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
    // Straight ways that stay on the sheet: within a quarter turn, clear of the upper rim.
    const Eigen::Vector2d a = unrolled(source);
    const Eigen::Vector2d b = unrolled(v);
    if (std::abs(std::remainder(sheet.flat[v].x(), 2.0 * kPi)) > kPi / 2.0) continue;
    const double t = std::clamp(a.dot(a - b) / (a - b).squaredNorm(), 0.0, 1.0);
    if (v == source || (a + t * (b - a)).norm() < 0.52) continue;
    ASSERT_NEAR(map.r[v], (b - a).norm(), kExact) << v;
    // The sheet's columns run clockwise about the apex in the unrolled plane's own coordinates.
    const double phi = kPi - std::atan2(b.y() - a.y(), b.x() - a.x());
    ASSERT_NEAR(std::remainder(map.phi[v] - phi, 2.0 * kPi), 0.0, 1e-8) << v;
    ++compared;
  }
  EXPECT_GT(compared, 300);
}

TEST(LogMap, AgreesWithArcLengthOnASphere) {
  const test::SphereError error = test::errorOnASphere(
      test::mixedSourcesOnASphere(), [](const TriangleMesh& mesh, const SurfacePoint& source,
                                        const Eigen::Vector3d& direction, double radius) {
        return computeLogMap(mesh, source, direction, radius);
      });
  EXPECT_LT(error.r, 4e-4);
  EXPECT_LT(error.phi, 8e-4);
}

TEST(LogMap, FollowsARotationOfTheMesh) {
  const TriangleMesh sphere = makeSphere(0.05, 3);
  const Eigen::Affine3d X(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  const SurfacePoint source{100, {0.2, 0.5, 0.3}};
  const Eigen::Vector3d direction(0.3, 0.8, 0.4);
  const LogMap one = computeLogMap(sphere, source, direction, 0.05);
  const LogMap two = computeLogMap(transformed(sphere, X), source, X * direction, 0.05);
  ASSERT_EQ(one.vertices.size(), two.vertices.size());
  for (const int v : one.vertices) {
    EXPECT_LT((logCoordinatesAtVertex(one, v) - logCoordinatesAtVertex(two, v)).norm(), 1e-9);
  }
}

TEST(LogMap, DoesNotDependOnTheNumbering) {
  const test::Sheet sheet = test::makePlane();
  const int n = sheet.mesh.vertexCount();
  Eigen::Matrix3Xd vertices(3, n);
  for (int v = 0; v < n; ++v)
    vertices.col(n - 1 - v) = sheet.mesh.vertex(v);
  const Eigen::Matrix3Xi faces = (n - 1 - sheet.mesh.faces().array()).rowwise().reverse();
  const TriangleMesh renumbered(vertices, faces);
  const int v = 400;
  const LogMap one = computeLogMap(sheet.mesh, surfacePointAtVertex(sheet.mesh, v),
                                   Eigen::Vector3d::UnitX(), 0.3);
  const LogMap two = computeLogMap(renumbered, surfacePointAtVertex(renumbered, n - 1 - v),
                                   Eigen::Vector3d::UnitX(), 0.3);
  ASSERT_EQ(one.vertices.size(), two.vertices.size());
  for (const int w : one.vertices)
    EXPECT_NEAR(one.r[w], two.r[n - 1 - w], kExact);
}

TEST(LogMap, MarksUnreachableVerticesNaN) {
  const TriangleMesh two = merged({makeSphere(1.0, 2), makeSphere(1.0, 2)});
  const LogMap map =
      computeLogMap(two, surfacePointAtVertex(two, 0), {0.1, 0.2, 0.9}, kEverything);
  EXPECT_EQ(map.vertices.size(), 162U);
  for (int v = 162; v < 324; ++v)
    EXPECT_TRUE(std::isnan(map.r[v]) && std::isnan(map.phi[v]));
}

TEST(LogMap, StopsAtItsRadiusAndSortsByDistance) {
  const test::Sheet sheet = test::makePlane();
  const LogMap map = computeLogMap(sheet.mesh, surfacePointAtVertex(sheet.mesh, 480),
                                   Eigen::Vector3d::UnitX(), 0.25);
  EXPECT_TRUE(std::is_sorted(map.vertices.begin(), map.vertices.end(), [&](int a, int b) {
    return map.r[a] < map.r[b];
  }));
  std::size_t within = 0;
  for (const Eigen::Vector2d& p : sheet.flat)
    within += (p - sheet.flat[480]).norm() <= 0.25;
  EXPECT_EQ(map.vertices.size(), within);
}

TEST(LogMap, RescalesTheAnglesAroundABoxCorner) {
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  const LogMap map = computeLogMap(box, surfacePointAtVertex(box, 7), {-1.0, 0.0, 0.0}, 1.1);
  // Vertices 6, 5, 3 stand at the ends of the corner's three edges: a third of a turn apart.
  EXPECT_NEAR(map.phi[6], 0.0, 1e-12);
  EXPECT_NEAR(std::abs(map.phi[5]), 2.0 * kPi / 3.0, 1e-12);
  EXPECT_NEAR(map.phi[3], -map.phi[5], 1e-12);
}

TEST(LogMap, RefusesWrongInput) {
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  const SurfacePoint good{0, {0.2, 0.5, 0.3}};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  EXPECT_THROW(computeLogMap(box, {12, {0.2, 0.5, 0.3}}, x, 1.0), InvalidInput);
  EXPECT_THROW(computeLogMap(box, {0, {0.2, 0.5, std::nan("")}}, x, 1.0), InvalidInput);
  EXPECT_THROW(computeLogMap(box, good, x, 0.0), InvalidInput);
  EXPECT_THROW(computeLogMap(box, good, x, std::nan("")), InvalidInput);
  EXPECT_THROW(computeLogMap(box, good, Eigen::Vector3d::Zero(), 1.0), InvalidInput);
  EXPECT_THROW(computeLogMap(box, good, box.faceNormals().col(0), 1.0), InvalidInput);
  EXPECT_THROW(logMapMethodFrom("slow"), InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
