#include "core/geometry/heat_log_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/geometry/sheet.h"
#include "tests/core/geometry/sphere_error.h"

namespace handgraft::geometry {
namespace {

constexpr double kEverything = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

Eigen::Vector2d turned(const Eigen::Vector2d& v, double angle) {
  return Eigen::Rotation2Dd(angle) * v;
}

/// About as a hand's skin is: 10k vertices about 2 mm apart, bumps, ridges and saddles.
TriangleMesh makeSkin(int subdivisions = 5) {
  const TriangleMesh sphere = makeSphere(1.0, subdivisions);
  Eigen::Matrix3Xd vertices = sphere.vertices();
  for (int v = 0; v < sphere.vertexCount(); ++v) {
    const Eigen::Vector3d p = sphere.vertex(v);
    const double radius_m = 0.05 * (1.0 + 0.15 * std::sin(3.0 * p.x()) * std::cos(4.0 * p.y()));
    vertices.col(v) = radius_m * Eigen::Vector3d(p.x(), 0.8 * p.y(), 1.2 * p.z());
  }
  return {vertices, sphere.faces()};
}

/// A vertex, inside a face, on an edge.
std::vector<SurfacePoint> sourcesOf(const TriangleMesh& mesh) {
  return {surfacePointAtVertex(mesh, mesh.vertexCount() / 2 + 3),
          {mesh.faceCount() / 2 + 7, {0.2, 0.5, 0.3}},
          {mesh.faceCount() / 3 + 5, {0.0, 0.4, 0.6}}};
}

/// At a vertex and beside it, inside a face, on an edge.
const Eigen::Vector3d kinds_of_source[] = {
    {0.0, 0.0, 1.0}, {0.1, 0.8, 0.1}, {0.2, 0.5, 0.3}, Eigen::Vector3d::Constant(1.0 / 3.0),
    {0.0, 0.4, 0.6}, {0.5, 0.5, 0.0}};

void expectIdentity(const test::Sheet& sheet) {
  const HeatLogMap solver(sheet.mesh);
  const Eigen::Vector3d direction(0.3, 0.8, 0.1);
  const double azimuth = std::atan2(0.8, 0.3);
  std::vector<SurfacePoint> sources = sourcesOf(sheet.mesh);
  sources.push_back(surfacePointAtVertex(sheet.mesh, 0));
  sources.push_back(surfacePointAtVertex(sheet.mesh, 5));
  sources.push_back({0, {0.4, 0.0, 0.6}});
  for (const SurfacePoint& source : sources) {
    const LogMap map = solver.smooth(source, direction, kEverything);
    ASSERT_EQ(map.vertices.size(), sheet.flat.size());
    EXPECT_EQ(static_cast<int>(map.faces.size()), sheet.mesh.faceCount());
    const Eigen::Vector2d origin = positionOf(sheet.mesh, source).head<2>();
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      const Eigen::Vector2d truth = turned(sheet.flat[v] - origin, -azimuth);
      ASSERT_LT((logCoordinatesAtVertex(map, v) - truth).norm(), 1e-11) << v;
    }
  }
}

TEST(HeatLogMap, SmoothIsIdentityOnAPlane) {
  expectIdentity(test::makePlane());
}

TEST(HeatLogMap, SmoothIsIdentityOnAPlaneOfSlivers) {
  expectIdentity(test::makePlane(0.24, 0.01));
}

TEST(HeatLogMap, SmoothUnrollsACylinder) {
  const auto [sides, width, sheet] = test::makeTube(64, 30, 3.0, 0.2);
  const HeatLogMap solver(sheet.mesh);
  for (const int source : {15 * sides + 20, 3 * sides, 20}) {
    const LogMap map = solver.smooth(surfacePointAtVertex(sheet.mesh, source),
                                     Eigen::Vector3d::UnitZ(), kEverything);
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      Eigen::Vector2d truth = sheet.flat[v] - sheet.flat[source];
      truth.x() = std::remainder(truth.x(), width);
      // Heat that went the other way round fades by a factor at every edge.
      if (std::abs(truth.x()) > 0.125 * width) continue;
      ASSERT_LT((logCoordinatesAtVertex(map, v) - turned(truth, -kPi / 2)).norm(), 1e-9) << v;
    }
  }
}

TEST(HeatLogMap, SmoothAgreesWithArcLengthOnASphere) {
  const TriangleMesh sphere = makeSphere(1.0, 5);
  const HeatLogMap solver(sphere);
  const auto smooth = [&](const TriangleMesh&, const auto&... query) {
    return solver.smooth(query...);
  };
  for (const Eigen::Vector3d& barycentric : kinds_of_source) {
    const test::SphereError error =
        test::errorOnASphere(test::sourcesOnASphere(barycentric, 6), smooth);
    EXPECT_LT(error.r, 1.5e-3) << barycentric.transpose();
    EXPECT_LT(error.phi, 1e-4) << barycentric.transpose();
  }
}

TEST(HeatLogMap, HeatIsCoarserOnASphere) {
  const TriangleMesh sphere = makeSphere(1.0, 5);
  const HeatLogMap solver(sphere);
  const auto heat = [&](const TriangleMesh&, const auto&... query) {
    return solver.heat(query...);
  };
  for (const Eigen::Vector3d& barycentric : kinds_of_source) {
    const test::SphereError error =
        test::errorOnASphere(test::sourcesOnASphere(barycentric, 6), heat);
    EXPECT_LT(error.r, 1e-2);
    EXPECT_LT(error.phi, 8e-3);
  }
}

TEST(HeatLogMap, HeatIsWithinAnEdgeOnAPlane) {
  const test::Sheet sheet = test::makePlane();
  const HeatLogMap solver(sheet.mesh);
  for (const SurfacePoint& source :
       {surfacePointAtVertex(sheet.mesh, 480),
        SurfacePoint{sheet.mesh.faceCount() / 2 + 30, {0.2, 0.5, 0.3}}}) {
    const Eigen::Vector2d origin = positionOf(sheet.mesh, source).head<2>();
    const LogMap map = solver.heat(source, Eigen::Vector3d::UnitX(), 0.3);
    double error = 0.0;
    for (const int v : map.vertices)
      error += (logCoordinatesAtVertex(map, v) - (sheet.flat[v] - origin)).norm();
    EXPECT_GT(map.vertices.size(), 150U);
    EXPECT_LT(error / static_cast<double>(map.vertices.size()), sheet.mesh.meanEdgeLength());
  }
}

TEST(HeatLogMap, HasTheAxisAndTheDistancesOfFastOnASkin) {
  const TriangleMesh skin = makeSkin();
  const HeatLogMap solver(skin);
  std::mt19937 random(5);
  for (int i = 0; i < 9; ++i) {
    SurfacePoint source{static_cast<int>(random() % 20480), {0.2, 0.5, 0.3}};
    if (i % 3 == 1) source.barycentric = {0.0, 0.4, 0.6};
    if (i % 3 == 2) source.barycentric = {0.0, 0.0, 1.0};
    const Eigen::Vector3d direction = normalOf(skin, source).unitOrthogonal();
    constexpr double kRadius = 0.02;
    const LogMap fast = computeLogMap(skin, source, direction, kRadius);
    const LogMap smooth = solver.smooth(source, direction, kRadius);
    const LogMap heat = solver.heat(source, direction, kRadius);
    double smooth_mm = 0.0;
    double heat_mm = 0.0;
    int count = 0;
    for (const int v : fast.vertices) {
      const Eigen::Vector2d p_T = logCoordinatesAtVertex(fast, v);
      const Eigen::Vector2d to_smooth = logCoordinatesAtVertex(smooth, v) - p_T;
      const Eigen::Vector2d to_heat = logCoordinatesAtVertex(heat, v) - p_T;
      // At the very rim one method may see a vertex inside that another one does not.
      if (!to_smooth.allFinite() || !to_heat.allFinite()) continue;
      smooth_mm += 1e3 * to_smooth.norm();
      heat_mm += 1e3 * to_heat.norm();
      ++count;
    }
    EXPECT_GT(count, 0.95 * static_cast<double>(fast.vertices.size()));
    EXPECT_LT(smooth_mm / count, 0.15) << i;
    EXPECT_LT(heat_mm / count, 0.5) << i;
  }
}

TEST(HeatLogMap, FollowsRotationAndScaleOfTheMesh) {
  const TriangleMesh skin = makeSkin(3);
  const HeatLogMap solver(skin);
  for (const double scale : {1e-3, 1.0, 1e3}) {
    Eigen::Affine3d X(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    X.scale(scale);
    const HeatLogMap moved(transformed(skin, X));
    for (const SurfacePoint& source : sourcesOf(skin)) {
      const Eigen::Vector3d direction(0.3, 0.8, 0.4);
      const LogMap one = solver.smooth(source, direction, 0.03);
      const LogMap two = moved.smooth(source, X.linear() * direction, 0.03 * scale);
      ASSERT_EQ(one.vertices.size(), two.vertices.size());
      ASSERT_GT(one.vertices.size(), 20U);
      for (const int v : one.vertices) {
        EXPECT_LT(
            (logCoordinatesAtVertex(one, v) - logCoordinatesAtVertex(two, v) / scale).norm(),
            1e-11);
      }
    }
  }
}

TEST(HeatLogMap, DoesNotDependOnTheNumbering) {
  const TriangleMesh skin = makeSkin(3);
  const int n = skin.vertexCount();
  const Eigen::Matrix3Xi faces = (n - 1 - skin.faces().array()).rowwise().reverse();
  const TriangleMesh renumbered(skin.vertices().rowwise().reverse(), faces);
  const HeatLogMap solver(skin);
  const HeatLogMap other(renumbered);
  const Eigen::Vector3d direction(0.3, 0.8, 0.4);
  for (const SurfacePoint& source : sourcesOf(skin)) {
    const SurfacePoint same{skin.faceCount() - 1 - source.face, source.barycentric};
    for (const bool smooth : {true, false}) {
      const LogMap one = smooth ? solver.smooth(source, direction, 0.03)
                                : solver.heat(source, direction, 0.03);
      const LogMap two =
          smooth ? other.smooth(same, direction, 0.03) : other.heat(same, direction, 0.03);
      ASSERT_EQ(one.vertices.size(), two.vertices.size());
      for (const int v : one.vertices) {
        EXPECT_LT(
            (logCoordinatesAtVertex(one, v) - logCoordinatesAtVertex(two, n - 1 - v)).norm(),
            1e-11);
      }
    }
  }
}

TEST(HeatLogMap, FillsTheDiskUpToItsRadius) {
  const TriangleMesh skin = makeSkin(3);
  const HeatLogMap solver(skin);
  constexpr double kRadius = 0.025;
  for (const SurfacePoint& source : sourcesOf(skin)) {
    for (const bool smooth : {true, false}) {
      const LogMap map = smooth ? solver.smooth(source, {0.3, 0.8, 0.4}, kRadius)
                                : solver.heat(source, {0.3, 0.8, 0.4}, kRadius);
      EXPECT_TRUE(std::is_sorted(map.vertices.begin(), map.vertices.end(), [&](int a, int b) {
        return map.r[a] < map.r[b];
      }));
      EXPECT_EQ(map.vertices.size(),
                static_cast<std::size_t>((map.r.array() <= kRadius).count()));
      EXPECT_LT(map.vertices.size(), static_cast<std::size_t>(skin.vertexCount()) / 2);
      const LogMapInverse inverse(skin, map);
      for (int i = 0; i < 60; ++i) {
        const Eigen::Vector2d uv_T =
            turned(Eigen::Vector2d(kRadius * 0.999 * (i + 1) / 60.0, 0.0), 0.7 * i);
        const LogMapInverse::Place place = inverse.at(uv_T);
        ASSERT_TRUE(place.point.valid()) << i;
        EXPECT_LT((logCoordinates(skin, map, place.point) - uv_T).norm(), 1e-12);
      }
    }
  }
}

TEST(HeatLogMap, GivesTheSameInsideWhateverTheRadius) {
  const TriangleMesh skin = makeSkin();
  const HeatLogMap solver(skin);
  for (const SurfacePoint& source : sourcesOf(skin)) {
    const LogMap whole = solver.smooth(source, {0.3, 0.8, 0.4}, kEverything);
    for (const double radius : {0.003, 0.01, 0.03}) {
      const LogMap map = solver.smooth(source, {0.3, 0.8, 0.4}, radius);
      ASSERT_GT(map.vertices.size(), 3U);
      for (const int v : map.vertices) {
        EXPECT_LT((logCoordinatesAtVertex(map, v) - logCoordinatesAtVertex(whole, v)).norm(),
                  1e-10 * radius);
      }
    }
  }
}

TEST(HeatLogMap, SurvivesCoarseMeshes) {
  Eigen::Matrix3Xd corners(3, 3);
  corners << 0, 1, 0, 0, 0, 1, 0, 0, 0;
  const TriangleMesh triangle(corners, Eigen::Vector3i(0, 1, 2));
  for (const TriangleMesh& mesh :
       {triangle, makeBox({1.0, 1.0, 1.0}), makeBox({1.0, 0.1, 0.01}),
        makeCylinder(1.0, 1.0, 3), makeSphere(1.0, 0)}) {
    const HeatLogMap solver(mesh);
    for (const SurfacePoint& source :
         {SurfacePoint{0, {0.2, 0.5, 0.3}}, SurfacePoint{0, {0.0, 0.4, 0.6}},
          surfacePointAtVertex(mesh, 0)}) {
      const Eigen::Vector3d direction = normalOf(mesh, source).unitOrthogonal();
      for (const LogMap& map : {solver.smooth(source, direction, kEverything),
                                solver.heat(source, direction, kEverything)}) {
        EXPECT_GE(map.vertices.size(), 3U);
        for (const int v : map.vertices) {
          EXPECT_TRUE(std::isfinite(map.r[v]) && std::isfinite(map.phi[v]));
          EXPECT_GE(map.r[v], 0.9 * (mesh.vertex(v) - positionOf(mesh, source)).norm());
        }
      }
    }
  }
}

TEST(HeatLogMap, EndsOnAbsurdSizes) {
  for (const double size : {1e-200, 1e-100, 1e100, 1e200}) {
    const TriangleMesh mesh =
        transformed(makeSkin(2), Eigen::Affine3d(Eigen::Scaling(size, 0.1 * size, size)));
    const SurfacePoint source = surfacePointAtVertex(mesh, 3);
    try {
      const LogMap map = HeatLogMap(mesh).smooth(source, {0.3, 0.8, 0.4}, 0.1 * size);
      for (const int v : map.vertices)
        EXPECT_TRUE(std::isfinite(map.r[v]) && std::isfinite(map.phi[v]));
    } catch (const InvalidInput&) {
      continue;  // out of range, and said so
    }
  }
}

TEST(HeatLogMap, ServesOneComponentWhateverTheOthersAre) {
  Eigen::Matrix3Xd vertices(3, 5);
  vertices << 5, 6, 5, 4, 5,  //
      0, 0, 1, 0, -1,         //
      0, 0, 0, 0, 1;
  Eigen::Matrix3Xi pinched(3, 2);
  pinched << 0, 0, 1, 3, 2, 4;
  const TriangleMesh sphere = makeSphere(1.0, 2);
  const TriangleMesh mesh = merged({sphere, TriangleMesh(vertices, pinched), sphere});
  const HeatLogMap solver(mesh);
  const LogMap map = solver.smooth(surfacePointAtVertex(mesh, 3), {0.1, 0.2, 0.9}, 2.0);
  EXPECT_GT(map.vertices.size(), 50U);
  for (int v = 162; v < mesh.vertexCount(); ++v)
    EXPECT_TRUE(std::isnan(map.r[v]) && std::isnan(map.phi[v]));
  try {
    static_cast<void>(solver.smooth(surfacePointAtVertex(mesh, 163), {0.1, 0.9, 0.2}, 2.0));
    FAIL() << "a pinched component was served";
  } catch (const InvalidInput& error) {
    // In the numbers of the mesh that was given.
    EXPECT_NE(std::string(error.what()).find("vertex 162"), std::string::npos) << error.what();
  }
  // The last sphere gives what the first one gives.
  const LogMap last = solver.smooth(surfacePointAtVertex(mesh, 170), {0.1, 0.2, 0.9}, 2.0);
  for (const int v : map.vertices)
    EXPECT_NEAR(last.r[v + 167], map.r[v], 1e-12);
}

TEST(HeatLogMap, IsAMethodOfComputeLogMap) {
  const TriangleMesh skin = makeSkin(3);
  const HeatLogMap solver(skin);
  const SurfacePoint source = surfacePointAtVertex(skin, 40);
  for (const LogMapMethod method : {LogMapMethod::kSmooth, LogMapMethod::kHeat}) {
    EXPECT_EQ(logMapMethodFrom(nameOf(method)), method);
    const LogMap once = computeLogMap(skin, source, {0.3, 0.8, 0.4}, 0.02, method);
    const LogMap kept = method == LogMapMethod::kSmooth
                            ? solver.smooth(source, {0.3, 0.8, 0.4}, 0.02)
                            : solver.heat(source, {0.3, 0.8, 0.4}, 0.02);
    EXPECT_EQ(once.method, method);
    EXPECT_EQ(kept.method, method);
    ASSERT_EQ(once.vertices, kept.vertices);
    for (const int v : once.vertices)
      EXPECT_EQ(once.r[v], kept.r[v]);
  }
}

TEST(HeatLogMap, RefusesWrongInput) {
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  const HeatLogMap solver(box);
  const SurfacePoint good{0, {0.2, 0.5, 0.3}};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  EXPECT_THROW(static_cast<void>(solver.smooth({12, {0.2, 0.5, 0.3}}, x, 1.0)), InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.smooth({0, {0.2, 0.5, std::nan("")}}, x, 1.0)),
               InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.smooth(good, x, 0.0)), InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.heat(good, x, std::nan(""))), InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.heat(good, Eigen::Vector3d::Zero(), 1.0)),
               InvalidInput);
  EXPECT_THROW(static_cast<void>(solver.smooth(good, box.faceNormals().col(0), 1.0)),
               InvalidInput);
}

TEST(HeatLogMap, AnswersSeveralThreadsAsOne) {
  const TriangleMesh skin = makeSkin(3);
  constexpr int kQueries = 12;
  const auto query = [&](const HeatLogMap& solver, int i) {
    const SurfacePoint source = sourcesOf(skin)[static_cast<std::size_t>(i % 3)];
    const Eigen::Vector3d direction = normalOf(skin, source).unitOrthogonal();
    return i % 2 == 0 ? solver.smooth(source, direction, 0.02)
                      : solver.heat(source, direction, 0.02);
  };
  const HeatLogMap alone(skin);
  // A solver of its own: `heat` factors its third system when several threads ask first.
  const HeatLogMap shared(skin);
  std::vector<LogMap> maps(kQueries);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = t; i < kQueries; i += 4)
        maps[static_cast<std::size_t>(i)] = query(shared, i);
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  for (int i = 0; i < kQueries; ++i) {
    const LogMap expected = query(alone, i);
    const LogMap& map = maps[static_cast<std::size_t>(i)];
    ASSERT_FALSE(expected.vertices.empty());
    ASSERT_EQ(map.vertices, expected.vertices) << i;
    for (const int v : expected.vertices) {
      ASSERT_EQ(map.r[v], expected.r[v]) << i;
      ASSERT_EQ(map.phi[v], expected.phi[v]) << i;
    }
  }
}

}  // namespace
}  // namespace handgraft::geometry
