#include "core/geometry/straightest_geodesic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/straight_way.h"
#include "core/geometry/tangent_direction.h"

#include "tests/core/geometry/sheet.h"

namespace handgraft::geometry {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-9;

/// Inside a face, on an edge, at a vertex; away from the edge of a sheet.
std::vector<SurfacePoint> startsOn(const TriangleMesh& mesh) {
  return {{mesh.faceCount() / 2 + 33, {0.2, 0.5, 0.3}},
          {mesh.faceCount() / 2 + 31, {0.0, 0.4, 0.6}},
          surfacePointAtVertex(mesh, mesh.vertexCount() / 2 + 3)};
}

double lengthOf(const TriangleMesh& mesh, const std::vector<SurfacePoint>& trace) {
  double length = 0.0;
  for (std::size_t i = 1; i < trace.size(); ++i)
    length += (positionOf(mesh, trace[i]) - positionOf(mesh, trace[i - 1])).norm();
  return length;
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// === Closed forms

void expectStraightLines(const TriangleMesh& plane, double length) {
  for (const SurfacePoint& start : startsOn(plane)) {
    const Eigen::Vector3d p = positionOf(plane, start);
    for (int k = 0; k < 24; ++k) {  // along edges and diagonals of the regular one, too
      const double angle = k * kPi / 12.0;
      const Eigen::Vector3d d(std::cos(angle), std::sin(angle), 0.0);
      const StraightWalk walk = walkStraight(plane, start, d, length);
      ASSERT_EQ(walk.end, WalkEnd::kArrived);
      EXPECT_LT((positionOf(plane, walk.point) - (p + length * d)).norm(), kExact);
      EXPECT_LT((walk.direction - d).norm(), kExact);
      EXPECT_EQ(walk.length, length);
      EXPECT_NEAR(lengthOf(plane, walk.trace), length, kExact);
    }
  }
}

TEST(StraightWalk, IsALineOnAPlane) {
  expectStraightLines(test::makePlane().mesh, 0.3);
}

TEST(StraightWalk, GoesThroughVerticesAndAlongEdgesOfARegularPlane) {
  expectStraightLines(test::makePlane(0.0).mesh, 0.3);
}

TEST(StraightWalk, IsALineOnAPlaneOfSlivers) {
  expectStraightLines(test::makePlane(0.24, 0.01).mesh, 0.004);
}

TEST(StraightWalk, AddsItsHeadingToTheDirection) {
  const TriangleMesh plane = test::makePlane().mesh;
  for (const SurfacePoint& start : startsOn(plane)) {
    const StraightWalk walk =
        walkStraight(plane, start, Eigen::Vector3d::UnitX(), 0.2, kPi / 2);
    const Eigen::Vector3d way = positionOf(plane, walk.point) - positionOf(plane, start);
    EXPECT_LT((way - 0.2 * Eigen::Vector3d::UnitY()).norm(), kExact);
  }
}

TEST(StraightWalk, IsAHelixOnACylinder) {
  constexpr int kSides = 64;
  const double width = 2.0 * kSides * std::sin(kPi / kSides);  // of the polyhedron, radius 1
  const test::Sheet sheet =
      test::makeSheet(kSides, 30, width, 3.0, 0.2, true, [&](const Eigen::Vector2d& p) {
        const double angle = 2.0 * kPi * p.x() / width;
        return Eigen::Vector3d(std::cos(angle), std::sin(angle), p.y());
      });
  const int from = 3 * kSides + 20;
  const SurfacePoint start = surfacePointAtVertex(sheet.mesh, from);
  for (const int to : {25 * kSides + 50, 20 * kSides + 3, 3 * kSides + 33}) {
    for (const int turns : {0, 1, -2}) {
      Eigen::Vector2d way = sheet.flat[to] - sheet.flat[from];
      way.x() += turns * width;
      const double heading = std::atan2(-way.x(), way.y());
      const StraightWalk walk =
          walkStraight(sheet.mesh, start, Eigen::Vector3d::UnitZ(), way.norm(), heading);
      EXPECT_LT((positionOf(sheet.mesh, walk.point) - sheet.mesh.vertex(to)).norm(), kExact);
    }
  }
}

/// A fan of `sides` equal triangles around an apex, radius 1 along the slant.
TriangleMesh makeFan(int sides, double apex_angle) {
  // Rim vertices wobble up and down so that any apex angle fits, saddles as well.
  const double each = apex_angle / sides;
  Eigen::Matrix3Xd vertices(3, sides + 1);
  vertices.col(0).setZero();
  double height = 0.0;
  const auto chord = [&](double h) {
    // Neighbours at (+h, -h): cosine of the angle between them.
    const double c = std::sqrt(1.0 - h * h);
    return c * c * std::cos(2.0 * kPi / sides) - h * h;
  };
  if (apex_angle > 2.0 * kPi) {
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 200; ++i) {
      height = 0.5 * (low + high);
      (chord(height) > std::cos(each) ? low : high) = height;
    }
  }
  const double flat = std::sin(0.5 * each) / std::sin(kPi / sides);  // rim radius of a cone
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * kPi * k / sides;
    const double h = apex_angle > 2.0 * kPi ? (k % 2 == 0 ? height : -height)
                                            : -std::sqrt(1.0 - flat * flat);
    const double rim = std::sqrt(1.0 - h * h);
    vertices.col(1 + k) << rim * std::cos(angle), rim * std::sin(angle), h;
  }
  Eigen::Matrix3Xi faces(3, sides);
  for (int k = 0; k < sides; ++k)
    faces.col(k) << 0, 1 + k, 1 + (k + 1) % sides;
  return {vertices, faces};
}

TEST(StraightWalk, LeavesHalfOfAVertexAngleOnEitherSide) {
  for (const double apex_angle : {1.4 * kPi, 1.9 * kPi, 2.0 * kPi, 2.6 * kPi}) {
    constexpr int kSides = 12;
    const TriangleMesh fan = makeFan(kSides, apex_angle);
    ASSERT_NEAR(fan.angleSum(0), apex_angle, 1e-9);
    // From within face 0 to the apex and on: six faces further, at the same share.
    const SurfacePoint start{0, {0.6, 0.3, 0.1}};
    const Eigen::Vector3d to_apex = -positionOf(fan, start);
    const StraightWalk walk = walkStraight(fan, start, to_apex, 2.0 * to_apex.norm());
    ASSERT_EQ(walk.end, WalkEnd::kArrived);
    const SurfacePoint opposite{kSides / 2, {0.6, 0.3, 0.1}};
    EXPECT_LT((positionOf(fan, walk.point) - positionOf(fan, opposite)).norm(), kExact);
    EXPECT_LT((walk.direction - positionOf(fan, opposite).normalized()).norm(), kExact);
  }
}

TEST(StraightWalk, UnrollsAConeBesideItsApex) {
  const double apex_angle = 1.5 * kPi;
  const TriangleMesh cone = makeFan(24, apex_angle);
  // From the rim's direction 0 at 0.5, square to the ray: a straight line of the unrolled cone
  // meets the ray at angle b at 0.5 / cos b.
  const SurfacePoint start{0, {0.5, 0.5, 0.0}};
  const Eigen::Vector3d ray = cone.vertex(1);
  const double b = 5.0 * apex_angle / 24;  // five faces on
  const StraightWalk walk = walkStraight(cone, start, ray, 0.5 * std::tan(b), kPi / 2);
  ASSERT_EQ(walk.end, WalkEnd::kArrived);
  EXPECT_LT((positionOf(cone, walk.point) - 0.5 / std::cos(b) * cone.vertex(6)).norm(), kExact);
}

TEST(StraightWalk, ComesRoundOnASphere) {
  double previous = 1.0;
  for (const int subdivisions : {3, 4, 5}) {
    const TriangleMesh sphere = makeSphere(1.0, subdivisions);
    double worst = 0.0;
    for (int k = 0; k < 12; ++k) {
      const SurfacePoint start{37 * k, {0.2, 0.5, 0.3}};
      const Eigen::Vector3d p = positionOf(sphere, start);
      const Eigen::Vector3d d = p.cross(Eigen::Vector3d(0.3, -0.8, 0.5)).normalized();
      const StraightWalk walk = walkStraight(sphere, start, d, 2.0 * kPi);
      worst = std::max(worst, (positionOf(sphere, walk.point) - p).norm());
      worst = std::max(worst, (walk.direction - d).norm());
    }
    EXPECT_LT(worst, 0.55 * previous) << subdivisions;  // halved with the edges
    previous = worst;
  }
  EXPECT_LT(previous, 0.03);
}

TEST(StraightWalk, LeadsToThePlaceOfItsLogCoordinates) {
  const TriangleMesh sphere = makeSphere(0.05, 4);
  const Eigen::Vector3d direction(0.2, -0.5, 0.7);
  for (const SurfacePoint& start : startsOn(sphere)) {
    const LogMap map = computeLogMap(sphere, start, direction, 0.02, LogMapMethod::kExact);
    ASSERT_GT(map.vertices.size(), 50u);
    for (const int v : map.vertices) {
      if (map.r[v] == 0.0) continue;
      const StraightWalk walk = walkStraight(sphere, start, direction, map.r[v], map.phi[v]);
      EXPECT_LT((positionOf(sphere, walk.point) - sphere.vertex(v)).norm(), kExact) << v;
    }
  }
}

// === There and back

void expectThereAndBack(const TriangleMesh& mesh, double length, double tolerance = kExact) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  int arrived = 0;
  for (int k = 0; k < 200; ++k) {
    SurfacePoint start{static_cast<int>(random() % mesh.faceCount()), {0.2, 0.5, 0.3}};
    if (k % 3 == 1) start.barycentric = {0.6, 0.0, 0.4};
    if (k % 3 == 2) start.barycentric = {0.0, 1.0, 0.0};
    const Eigen::Vector3d n = normalOf(mesh, start);
    const Eigen::Vector3d d = n.unitOrthogonal() + share(random) * n.cross(n.unitOrthogonal());
    const double heading = 2.0 * kPi * share(random);
    const StraightWalk there = walkStraight(mesh, start, d, length, heading);
    if (there.end != WalkEnd::kArrived) continue;
    ++arrived;
    const StraightWalk back = walkStraight(mesh, there.point, there.direction, length, kPi);
    ASSERT_EQ(back.end, WalkEnd::kArrived);
    EXPECT_LT((positionOf(mesh, back.point) - positionOf(mesh, start)).norm(), tolerance) << k;
    const Eigen::Vector3d left = turnedDirection(mesh, start, d, heading);
    EXPECT_NEAR(
        std::remainder(angleFromTo(mesh, back.point, left, back.direction) - kPi, 2 * kPi), 0.0,
        tolerance)
        << k;
  }
  EXPECT_GT(arrived, 60);
}

TEST(StraightWalk, ComesBackOnASphere) {
  expectThereAndBack(makeSphere(1.0, 4), 2.0);
}

TEST(StraightWalk, ComesBackOnABox) {
  expectThereAndBack(makeBox({1.0, 0.7, 0.4}), 0.8);
}

TEST(StraightWalk, ComesBackOnABumpyPlane) {
  const test::Sheet sheet =
      test::makeSheet(30, 30, 1.0, 1.0, 0.24, false, [](const Eigen::Vector2d& p) {
        return Eigen::Vector3d(p.x(), p.y(), 0.05 * std::sin(9 * p.x()) * std::cos(7 * p.y()));
      });
  expectThereAndBack(sheet.mesh, 0.4);
}

TEST(StraightWalk, ComesBackOnABentPlaneOfSlivers) {
  const test::Sheet sheet =
      test::makeSheet(30, 30, 1.0, 0.01, 0.24, false, [](const Eigen::Vector2d& p) {
        return Eigen::Vector3d(p.x(), p.y(), 0.05 * std::sin(9 * p.x()));
      });
  expectThereAndBack(sheet.mesh, 0.002);
}

// === The way to a place

TEST(StraightWay, LeadsToThePlaceMeant) {
  const TriangleMesh sphere = makeSphere(0.05, 4);
  const Eigen::Vector3d direction(0.2, -0.5, 0.7);
  for (const SurfacePoint& start : startsOn(sphere)) {
    for (int k = 0; k < 40; ++k) {
      const SurfacePoint target{31 * k, {0.2, 0.5, 0.3}};
      const Eigen::Vector3d p = positionOf(sphere, target);
      const double arc =
          0.05 * angleBetween(positionOf(sphere, start).normalized(), p.normalized());
      if (arc > 0.1) continue;
      const auto way = straightWayTo(sphere, start, direction, target);
      ASSERT_TRUE(way.has_value());
      EXPECT_NEAR(way->length, arc, 0.005 * arc);
      const StraightWalk walk =
          walkStraight(sphere, start, direction, way->length, way->heading);
      EXPECT_NEAR((positionOf(sphere, walk.point) - p).norm(), way->miss, 1e-12);
      EXPECT_LT(way->miss, 3e-3 * arc);  // a vertex in between may split the ways
    }
  }
}

TEST(StraightWay, IsNoneWhereEveryWayBendsOrThereIsNone) {
  // A long slit from the edge of a plane: the way from one side of it to the other turns back.
  const TriangleMesh whole = test::makePlane(0.0).mesh;
  std::vector<int> corners;
  for (int f = 0; f < whole.faceCount(); ++f) {
    const Eigen::Vector3d centre = positionOf(whole, {f, Eigen::Vector3d::Constant(1.0 / 3.0)});
    const bool in_slit = centre.y() > 0.4 && centre.y() < 0.5 && centre.x() > 0.3;
    const Eigen::Vector3i face = whole.face(f);
    if (!in_slit) corners.insert(corners.end(), {face[0], face[1], face[2]});
  }
  const TriangleMesh slit(
      whole.vertices(),
      Eigen::Map<Eigen::Matrix3Xi>(corners.data(), 3, static_cast<int>(corners.size()) / 3));
  const auto nearest = [&](const Eigen::Vector3d& p) {
    int v = 0;
    (slit.vertices().colwise() - p).colwise().norm().minCoeff(&v);
    return surfacePointAtVertex(slit, v);
  };
  const SurfacePoint below = nearest({0.9, 0.3, 0});
  const SurfacePoint above = nearest({0.9, 0.6, 0});
  EXPECT_FALSE(straightWayTo(slit, below, {1, 0, 0}, above).has_value());
  EXPECT_TRUE(straightWayTo(slit, below, {1, 0, 0}, nearest({0.4, 0.2, 0})).has_value());
  const TriangleMesh two = merged({makeSphere(1.0, 2), makeSphere(2.0, 2)});
  EXPECT_FALSE(straightWayTo(two, {0, {0.2, 0.5, 0.3}}, {0.2, -0.5, 0.7},
                             {two.faceCount() - 1, {0.2, 0.5, 0.3}})
                   .has_value());
}

// === Where walks end

TEST(StraightWalk, StopsAtTheSurfaceEdgeAndSaysSo) {
  const TriangleMesh plane = test::makePlane().mesh;
  const SurfacePoint start{900, {0.2, 0.5, 0.3}};
  const Eigen::Vector3d p = positionOf(plane, start);
  const Eigen::Vector3d d = Eigen::Vector3d(0.8, 0.6, 0.0);
  const StraightWalk walk = walkStraight(plane, start, d, 100.0);
  EXPECT_EQ(walk.end, WalkEnd::kSurfaceEdge);
  const double expected = std::min((1.0 - p.x()) / 0.8, (1.0 - p.y()) / 0.6);
  EXPECT_NEAR(walk.length, expected, kExact);
  EXPECT_LT((positionOf(plane, walk.point) - (p + expected * d)).norm(), kExact);
  EXPECT_LT((walk.direction - d).norm(), kExact);
}

TEST(StraightWalk, FollowsAStraightSurfaceEdgeToItsCorner) {
  const TriangleMesh plane = test::makePlane(0.0).mesh;
  const SurfacePoint start = surfacePointAtVertex(plane, 10);  // x = 1/3, y = 0
  const StraightWalk walk = walkStraight(plane, start, Eigen::Vector3d::UnitX(), 5.0);
  EXPECT_EQ(walk.end, WalkEnd::kSurfaceEdge);
  EXPECT_LT((positionOf(plane, walk.point) - Eigen::Vector3d::UnitX()).norm(), kExact);
  const StraightWalk outwards = walkStraight(plane, start, -Eigen::Vector3d::UnitY(), 5.0);
  EXPECT_EQ(outwards.end, WalkEnd::kSurfaceEdge);
  EXPECT_EQ(outwards.length, 0.0);
}

TEST(StraightWalk, StopsAtANonManifoldEdge) {
  Eigen::Matrix3Xd vertices(3, 5);
  vertices << 0, 1, 0, 1, 0.5,  //
      0, 0, 1, 1, 0.5,          //
      0, 0, 0, 0, 1;
  Eigen::Matrix3Xi faces(3, 3);  // three faces at the diagonal
  faces << 0, 1, 1,              //
      1, 3, 4,                   //
      2, 2, 2;
  const TriangleMesh mesh(vertices, faces);
  ASSERT_EQ(mesh.nonManifoldEdgeCount(), 1);
  const StraightWalk walk = walkStraight(mesh, {0, {0.5, 0.25, 0.25}}, {1, 1, 0}, 3.0);
  EXPECT_EQ(walk.end, WalkEnd::kSurfaceEdge);
  EXPECT_LT((positionOf(mesh, walk.point) - Eigen::Vector3d(0.5, 0.5, 0)).norm(), kExact);
}

TEST(StraightWalk, OfNoLengthStaysAndTurns) {
  const TriangleMesh sphere = makeSphere(1.0, 3);
  for (const SurfacePoint& start : startsOn(sphere)) {
    const Eigen::Vector3d d(0.2, -0.5, 0.7);
    const StraightWalk walk = walkStraight(sphere, start, d, 0.0, 1.0);
    EXPECT_EQ(walk.end, WalkEnd::kArrived);
    EXPECT_EQ(walk.length, 0.0);
    EXPECT_LT((positionOf(sphere, walk.point) - positionOf(sphere, start)).norm(), 1e-15);
    EXPECT_LT((walk.direction - turnedDirection(sphere, start, d, 1.0)).norm(), 1e-12);
  }
}

TEST(StraightWalk, EndsAtAVertexWithHalfOfItsAngleAhead) {
  const TriangleMesh fan = makeFan(12, 1.4 * kPi);
  const SurfacePoint start{0, {0.6, 0.3, 0.1}};
  const Eigen::Vector3d to_apex = -positionOf(fan, start);
  const StraightWalk walk = walkStraight(fan, start, to_apex, to_apex.norm());
  ASSERT_EQ(vertexAt(fan, walk.point), 0);
  const Eigen::Vector3d opposite = positionOf(fan, {6, {0.6, 0.3, 0.1}}).normalized();
  EXPECT_LT((walk.direction - opposite).norm(), 1e-8);
}

// === Hostile meshes and wrong input

TEST(StraightWalk, EndsOnMeshesOfAnyShape) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  int crossings = 0;
  for (int mesh_number = 0; mesh_number < 200; ++mesh_number) {
    constexpr int kVertices = 9;
    Eigen::Matrix3Xd vertices(3, kVertices);
    for (int v = 0; v < kVertices; ++v) {
      vertices.col(v) << share(random), share(random), share(random);
      if (mesh_number % 2 == 0) vertices(2, v) = 0.0;                            // folded flat
      if (mesh_number % 5 == 0 && v > 5) vertices.col(v) = vertices.col(v - 4);  // no length
      if (mesh_number % 7 == 0) vertices(1, v) = 0.0;  // few directions
    }
    std::vector<int> corners;
    for (int f = 0; f < 14; ++f) {
      int order[kVertices];
      std::iota(order, order + kVertices, 0);
      std::shuffle(order, order + kVertices, random);
      corners.insert(corners.end(), order, order + 3);
    }
    const TriangleMesh mesh(vertices, Eigen::Map<Eigen::Matrix3Xi>(corners.data(), 3, 14));
    for (int f = 0; f < mesh.faceCount(); ++f) {
      for (const Eigen::Vector3d& weights :
           {Eigen::Vector3d(0.2, 0.5, 0.3), Eigen::Vector3d(0, 0.5, 0.5),
            Eigen::Vector3d(1, 0, 0)}) {
        StraightWalk walk;
        try {
          walk = walkStraight(mesh, {f, weights}, {share(random), share(random), share(random)},
                              50.0);
        } catch (const InvalidInput&) {
          continue;  // no tangent plane there
        }
        ASSERT_NO_THROW(validate(mesh, walk.point, "end"));
        ASSERT_TRUE(walk.direction.allFinite());
        crossings += static_cast<int>(walk.trace.size()) - 2;
        ASSERT_LE(walk.length, 50.0);
        for (const SurfacePoint& place : walk.trace)
          ASSERT_NO_THROW(validate(mesh, place, "trace"));
      }
    }
  }
  EXPECT_GT(crossings, 1000);
}

TEST(StraightWalk, RefusesWhatIsNoWalk) {
  const TriangleMesh plane = test::makePlane().mesh;
  const SurfacePoint start{900, {0.2, 0.5, 0.3}};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(walkStraight(plane, start, {kNaN, 0, 0}, 0.1), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, {0, 0, 0}, 0.1), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, Eigen::Vector3d::UnitZ(), 0.1), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, x, -0.1), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, x, kNaN), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, x, kInfinity), InvalidInput);
  EXPECT_THROW(walkStraight(plane, start, x, 0.1, kNaN), InvalidInput);
  EXPECT_THROW(walkStraight(plane, {1 << 20, {1, 0, 0}}, x, 0.1), InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
