#include "core/transfer/spine.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"

#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using contact::Patch;
using geometry::positionOf;
using geometry::SurfacePoint;
using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-9;
constexpr double kStep = 0.002;

/// A plate of 120 x 60 mm.
TriangleMesh plate() {
  return test::makePlate(60, 30, kStep);
}

TriangleMesh bent(const TriangleMesh& flat,
                  const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& bend) {
  Eigen::Matrix3Xd vertices = flat.vertices();
  for (int v = 0; v < flat.vertexCount(); ++v)
    vertices.col(v) = bend(flat.vertex(v));
  return {vertices, flat.faces()};
}

/// A patch about 14 mm wide along the given places of a flat mesh (or of it bent, whose faces
/// are the same), the `root`-th of which is the root.
Patch patchAlong(const TriangleMesh& flat,
                 const std::vector<Eigen::Vector2d>& knots,
                 std::size_t root = 0) {
  const geometry::SurfaceLocator locator(flat);
  const auto at = [&](const Eigen::Vector2d& p) {
    return locator.nearest({p.x(), p.y(), 0.0}).point;
  };
  Patch patch;
  patch.name = "palm";
  for (const Eigen::Vector2d& knot : knots) {
    patch.axis.push_back(at(knot));
    for (const double side : {-0.007, 0.007})
      patch.interpolation_boundary.push_back(at(knot + Eigen::Vector2d(0.0, side)));
  }
  patch.root = patch.axis[root];
  return patch;
}

const std::vector<Eigen::Vector2d> kBentLine = {{-0.0411, -0.0107},
                                                {-0.0283, 0.0013},
                                                {-0.0129, 0.0041},
                                                {0.0017, -0.0013},
                                                {0.0151, 0.0093}};

std::vector<Eigen::Vector3d> positionsOf(const TriangleMesh& mesh,
                                         const std::vector<std::optional<Station>>& stations) {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& station : stations)
    positions.push_back(positionOf(mesh, station.value().point));
  return positions;
}

TEST(Spine, OfAPlainPatchIsItsRoot) {
  const TriangleMesh mesh = plate();
  Patch patch = patchAlong(mesh, kBentLine);
  patch.axis.clear();
  const Spine spine = spineOf(mesh, patch, {0, 2, 0});
  ASSERT_EQ(spine.stations.size(), 1u);
  EXPECT_TRUE(spine.legs.empty());
  const auto stations = retraceMirrored(mesh, spine.stations[0], {});
  ASSERT_EQ(stations.size(), 1u);
  EXPECT_EQ(positionOf(mesh, stations[0]->point), positionOf(mesh, patch.root));
}

TEST(Spine, MeasuresTheAxisOnAPlane) {
  const TriangleMesh mesh = plate();
  const Patch patch = patchAlong(mesh, kBentLine, 2);
  const Eigen::Vector3d direction(0.6, 0.8, 0.0);
  const Spine spine = spineOf(mesh, patch, direction);
  ASSERT_EQ(spine.stations.size(), 5u);
  // The root, then on to the end, then from the root to the start.
  const int knots[] = {2, 3, 4, 1, 0};
  const int from[] = {0, 1, 0, 3};
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT(
        (positionOf(mesh, spine.stations[i].point).head<2>() - kBentLine[knots[i]]).norm(),
        kExact);
    EXPECT_LT((spine.stations[i].direction - direction).norm(), kExact);
    if (i == 0) continue;
    const SpineLeg& leg = spine.legs[i - 1];
    EXPECT_EQ(leg.from, from[i - 1]);
    const Eigen::Vector2d way = kBentLine[knots[i]] - kBentLine[knots[leg.from]];
    EXPECT_NEAR(leg.length, way.norm(), kExact);
    const double heading = std::atan2(way.y(), way.x()) - std::atan2(0.8, 0.6);
    EXPECT_NEAR(std::remainder(leg.heading - heading, 2 * kPi), 0.0, 1e-7);
  }
}

TEST(Spine, RetracedIsTheMirrorImageOnAPlane) {
  const TriangleMesh mesh = plate();
  const Patch patch = patchAlong(mesh, kBentLine, 2);
  const Spine spine = spineOf(mesh, patch, Eigen::Vector3d::UnitX());
  const auto stations = retraceMirrored(mesh, spine.stations[0], spine.legs);
  const auto positions = positionsOf(mesh, stations);
  const Eigen::Vector3d root = positions[0];
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Eigen::Vector3d expected = positionOf(mesh, spine.stations[i].point) - root;
    expected.y() = -expected.y();
    EXPECT_LT((positions[i] - root - expected).norm(), kExact) << i;
    EXPECT_LT((stations[i]->direction - Eigen::Vector3d::UnitX()).norm(), kExact) << i;
  }
}

/// Retraced twice, the second time with mirrored legs, the figure is the first again.
void expectIdentity(const TriangleMesh& mesh, const Patch& patch, double tolerance) {
  const Eigen::Vector3d n = normalOf(mesh, patch.root);
  const Spine spine = spineOf(mesh, patch, n.unitOrthogonal());
  std::vector<SpineLeg> mirrored = spine.legs;
  for (SpineLeg& leg : mirrored) {
    leg.heading = -leg.heading;
    leg.turn = -leg.turn;
  }
  const auto again = retraceMirrored(mesh, spine.stations[0], mirrored);
  ASSERT_EQ(again.size(), spine.stations.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    ASSERT_TRUE(again[i].has_value());
    const Eigen::Vector3d p = positionOf(mesh, spine.stations[i].point);
    EXPECT_LT((positionOf(mesh, again[i]->point) - p).norm(), tolerance) << i;
    EXPECT_LT(
        (again[i]->direction.normalized() - spine.stations[i].direction.normalized()).norm(),
        i == 0 ? 1.0 : tolerance)
        << i;
  }
}

TEST(Spine, RetracedUnmirroredIsItselfOnPlaneAndCylinder) {
  const TriangleMesh flat = plate();
  const Patch patch = patchAlong(flat, kBentLine, 2);
  expectIdentity(flat, patch, kExact);
  const double radius = 0.015;
  expectIdentity(bent(flat,
                      [&](const Eigen::Vector3d& p) {
                        const double angle = p.x() / radius;
                        return Eigen::Vector3d(radius * std::sin(angle), p.y(),
                                               radius * std::cos(angle));
                      }),
                 patch, kExact);
}

TEST(Spine, IsTheSameFigureOnSurfacesThatUnrollToAPlane) {
  const TriangleMesh flat = plate();
  const Patch patch = patchAlong(flat, kBentLine, 2);
  // A fold along y through the middle of the axis, between two rows of faces: two planes.
  const TriangleMesh folded = bent(flat, [](const Eigen::Vector3d& p) {
    const double x = p.x() + 0.008;
    return Eigen::Vector3d(x > 0.0 ? 0.5 * x : x, p.y(), x > 0.0 ? std::sqrt(0.75) * x : 0.0);
  });
  // A polyhedron with the sides of the plate's cells.
  const double angle = 0.2;
  const TriangleMesh rolled = bent(flat, [&](const Eigen::Vector3d& p) {
    const double radius = 0.5 * kStep / std::sin(0.5 * angle);
    const double turn = angle * p.x() / kStep;
    return Eigen::Vector3d(radius * std::sin(turn), p.y(), radius * std::cos(turn) - radius);
  });
  for (const TriangleMesh& surface : {folded, rolled}) {
    // Along y, which neither bends.
    const Spine here = spineOf(flat, patch, Eigen::Vector3d::UnitY());
    const Spine there = spineOf(surface, patch, Eigen::Vector3d::UnitY());
    ASSERT_EQ(there.legs.size(), here.legs.size());
    for (std::size_t i = 0; i < here.legs.size(); ++i) {
      EXPECT_NEAR(there.legs[i].length, here.legs[i].length, kExact);
      EXPECT_NEAR(std::remainder(there.legs[i].heading - here.legs[i].heading, 2 * kPi), 0.0,
                  1e-7);
    }
    // Face to face from the bent surface onto the plate: mirrored at the direction.
    const auto positions =
        positionsOf(flat, retraceMirrored(flat, here.stations[0], there.legs));
    for (std::size_t i = 0; i < positions.size(); ++i) {
      Eigen::Vector3d way = positionOf(flat, here.stations[i].point) - positions[0];
      way.x() = -way.x();
      EXPECT_LT((positions[i] - positions[0] - way).norm(), 1e-8) << i;
    }
  }
}

TEST(Spine, FollowsGreatCirclesOnASphere) {
  const double radius = 0.04;
  const TriangleMesh sphere = geometry::makeSphere(radius, 5);
  const geometry::SurfaceLocator locator(sphere);
  Patch patch;
  patch.name = "palm";
  for (const double turn : {-0.7, -0.35, 0.0, 0.35, 0.7}) {
    const Eigen::Vector3d p(std::sin(turn), 0.0, std::cos(turn));
    patch.axis.push_back(locator.nearest(radius * p).point);
    for (const double side : {-0.006, 0.006}) {
      patch.interpolation_boundary.push_back(
          locator.nearest(radius * p + Eigen::Vector3d(0, side, 0)).point);
    }
  }
  patch.root = patch.axis[2];
  expectIdentity(sphere, patch, kExact);
  const Spine spine = spineOf(sphere, patch, Eigen::Vector3d::UnitX());
  ASSERT_EQ(spine.legs.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(spine.legs[i].length, 0.35 * radius, 1e-3 * 0.35 * radius);
    EXPECT_NEAR(std::abs(std::remainder(spine.legs[i].heading, kPi)), 0.0, 2e-3);
  }
  // On a sphere with another mesh and twice the radius the same lengths are half the angles.
  const TriangleMesh large = geometry::makeSphere(2.0 * radius, 4);
  const Station root_large{geometry::SurfaceLocator(large).nearest({0, 0, 2 * radius}).point,
                           Eigen::Vector3d::UnitX()};
  const auto stations = retraceMirrored(large, root_large, spine.legs);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double turn = 0.5 * std::array{0.0, 0.35, 0.7, -0.35, -0.7}[i];
    const Eigen::Vector3d p = 2 * radius * Eigen::Vector3d(std::sin(turn), 0, std::cos(turn));
    EXPECT_LT((positionOf(large, stations[i].value().point) - p).norm(), 1.5e-4) << i;
  }
}

TEST(Spine, HasSamplesBetweenKnotsThatAreFarApart) {
  const TriangleMesh mesh = plate();
  Patch patch = patchAlong(mesh, {{-0.041, 0.003}, {0.031, 0.003}});
  const Spine spine = spineOf(mesh, patch, Eigen::Vector3d::UnitX());
  ASSERT_EQ(spine.stations.size(), 7u);  // 72 mm in pieces of at most 14
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector3d expected(-0.041 + i * 0.012, 0.003, 0.0);
    EXPECT_LT((positionOf(mesh, spine.stations[i].point) - expected).norm(), kExact);
  }
}

TEST(Spine, TurnsWithItsRootsDirection) {
  const TriangleMesh sphere = geometry::makeSphere(0.04, 4);
  const geometry::SurfaceLocator locator(sphere);
  Patch patch = patchAlong(plate(), kBentLine, 2);
  for (auto* points : {&patch.axis, &patch.interpolation_boundary}) {
    for (SurfacePoint& point : *points)
      point = locator.nearest(positionOf(plate(), point) + Eigen::Vector3d(0, 0, 0.04)).point;
  }
  patch.root = patch.axis[2];
  const Spine spine = spineOf(sphere, patch, {1, 0, 0});
  const Spine other = spineOf(sphere, patch, {0.3, -0.8, 0});
  const double angle = std::remainder(spine.legs[0].heading - other.legs[0].heading, 2 * kPi);
  const auto turned = turnedLegs(spine.legs, angle);
  for (std::size_t i = 0; i < turned.size(); ++i) {
    EXPECT_NEAR(turned[i].length, other.legs[i].length, kExact);
    EXPECT_NEAR(std::remainder(turned[i].heading - other.legs[i].heading, 2 * kPi), 0.0, 1e-7);
    EXPECT_NEAR(std::remainder(turned[i].turn - other.legs[i].turn, 2 * kPi), 0.0, 1e-7);
  }
}

TEST(Spine, LosesTheStationsBehindTheSurfaceEdge) {
  const TriangleMesh mesh = plate();
  const Patch patch =
      patchAlong(mesh, {{-0.04, 0}, {-0.02, 0}, {0, 0}, {0.02, 0}, {0.04, 0}}, 2);
  const Spine spine = spineOf(mesh, patch, Eigen::Vector3d::UnitX());
  const TriangleMesh small = test::makePlate(30, 15, kStep);  // 60 mm long
  const Station root{geometry::SurfaceLocator(small).nearest({0.005, 0, 0}).point,
                     Eigen::Vector3d::UnitX()};
  const auto stations = retraceMirrored(small, root, spine.legs);
  ASSERT_EQ(stations.size(), spine.stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double x = 0.005 + positionOf(mesh, spine.stations[i].point).x();
    EXPECT_EQ(stations[i].has_value(), std::abs(x) < 0.03) << x;
  }
}

TEST(Spine, NamesKnotsWithoutAStraightWay) {
  const TriangleMesh one = plate();
  const TriangleMesh two = geometry::merged(
      {one, geometry::transformed(one, Eigen::Affine3d(Eigen::Translation3d(0, 0, -0.001)))});
  Patch patch = patchAlong(one, kBentLine, 2);
  patch.axis[3].face += one.faceCount();
  EXPECT_THAT(
      [&] {
        spineOf(two, patch, Eigen::Vector3d::UnitX());
      },
      ThrowsMessage<InvalidInput>(HasSubstr("patch 'palm': no straight way leads along the "
                                            "surface from axis knot 2 to 3")));
}

}  // namespace
}  // namespace handgraft::transfer
