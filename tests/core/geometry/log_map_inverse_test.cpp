#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/geometry/log_map.h"

#include "tests/core/geometry/sheet.h"

namespace handgraft::geometry {
namespace {

constexpr double kEverything = std::numeric_limits<double>::infinity();

TEST(LogMapInverse, ComesBackToItsCoordinates) {
  const TriangleMesh sphere = makeSphere(1.0, 4);
  const LogMap map = computeLogMap(sphere, {11, {0.2, 0.5, 0.3}}, {0.3, 0.8, 0.4}, 1.2);
  const LogMapInverse inverse(sphere, map);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-0.8, 0.8);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d uv_T(coordinate(random), coordinate(random));
    const LogMapInverse::Place place = inverse.at(uv_T);
    ASSERT_TRUE(place.point.valid());
    ASSERT_LT((logCoordinates(sphere, map, place.point) - uv_T).norm(), 1e-9);
  }
}

TEST(LogMapInverse, FindsAnLShapeOnAPlane) {
  const test::Sheet sheet = test::makePlane();
  const SurfacePoint source{900, {0.2, 0.5, 0.3}};
  const LogMap map = computeLogMap(sheet.mesh, source, Eigen::Vector3d::UnitX(), kEverything);
  const LogMapInverse inverse(sheet.mesh, map);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0.2, 0.0), Eigen::Vector2d(0.0, 0.3), Eigen::Vector2d(0.1, 0.1)}) {
    const LogMapInverse::Place place = inverse.at(corner);
    ASSERT_TRUE(place.point.valid());
    EXPECT_FALSE(place.folded);
    const Eigen::Vector3d moved =
        positionOf(sheet.mesh, place.point) - positionOf(sheet.mesh, source);
    EXPECT_LT((moved.head<2>() - corner).norm(), 1e-9);
  }
}

TEST(LogMapInverse, ReachesUpToTheRadiusOnACoarseMesh) {
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  const SurfacePoint source{0, {0.4, 0.3, 0.3}};
  const LogMap map = computeLogMap(box, source, Eigen::Vector3d::UnitX(), 0.3);
  EXPECT_TRUE(map.vertices.empty());
  const LogMapInverse inverse(box, map);
  for (int i = 0; i < 12; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 12.0;
    const LogMapInverse::Place place =
        inverse.at({0.299 * std::cos(angle), 0.299 * std::sin(angle)});
    EXPECT_TRUE(place.point.valid()) << i;
  }
}

TEST(LogMapInverse, SaysWhyThereIsNoPlace) {
  const test::Sheet sheet = test::makePlane();
  const LogMap all =
      computeLogMap(sheet.mesh, {900, {0.2, 0.5, 0.3}}, Eigen::Vector3d::UnitX(), kEverything);
  EXPECT_EQ(LogMapInverse(sheet.mesh, all).at({1.5, 0.0}).reason, Unreachable::kSurfaceEdge);
  const LogMap disk =
      computeLogMap(sheet.mesh, {900, {0.2, 0.5, 0.3}}, Eigen::Vector3d::UnitX(), 0.2);
  EXPECT_EQ(LogMapInverse(sheet.mesh, disk).at({0.21, 0.0}).reason, Unreachable::kBeyondRadius);
  EXPECT_FALSE(LogMapInverse(sheet.mesh, disk).at({std::nan(""), 0.0}).point.valid());

  const TriangleMesh tube = makeCylinder(1.0, 20.0, 40);
  SurfacePoint middle;
  for (int f = 0; f < tube.faceCount(); ++f) {
    if (std::abs(tube.faceNormals()(2, f)) < 0.5) middle = {f, {0.25, 0.5, 0.25}};
  }
  const LogMap round = computeLogMap(tube, middle, Eigen::Vector3d::UnitZ(), 6.0);
  const LogMapInverse::Place behind = LogMapInverse(tube, round).at({0.0, 4.5});
  EXPECT_FALSE(behind.point.valid());
}

// One vertex is drawn past a neighbour: the face behind it turns over, and lies on others.
TEST(LogMapInverse, TellsOfFoldsButNeverTakesAFaceThatIsTurnedOver) {
  const test::Sheet sheet = test::makePlane();
  const TriangleMesh& mesh = sheet.mesh;
  LogMap map =
      computeLogMap(mesh, {900, {0.2, 0.5, 0.3}}, Eigen::Vector3d::UnitX(), kEverything);
  const int turned_over = 1300;
  const Eigen::Vector3i face = mesh.face(turned_over);
  const Eigen::Vector2d p_T = logCoordinatesAtVertex(map, face[0]);
  const Eigen::Vector2d a_T = logCoordinatesAtVertex(map, face[1]);
  const Eigen::Vector2d b_T = logCoordinatesAtVertex(map, face[2]);
  const Eigen::Vector2d drawn_T = p_T + 1.2 * (a_T + b_T - 2.0 * p_T);
  map.r[face[0]] = drawn_T.norm();
  map.phi[face[0]] = std::atan2(drawn_T.y(), drawn_T.x());

  const LogMapInverse inverse(mesh, map);
  const LogMapInverse::Place on_fold = inverse.at((drawn_T + a_T + b_T) / 3.0);
  ASSERT_TRUE(on_fold.point.valid());
  EXPECT_NE(on_fold.point.face, turned_over);
  EXPECT_TRUE(on_fold.folded);
  const LogMapInverse::Place far = inverse.at({p_T.x(), -p_T.y()});
  ASSERT_TRUE(far.point.valid());
  EXPECT_FALSE(far.folded);
}

TEST(LogMapInverse, StopsAtTheCutLocusOfACylinder) {
  constexpr int kSides = 48;
  const double width = 2.0 * kSides * std::sin(std::numbers::pi / kSides);
  const test::Sheet tube =
      test::makeSheet(kSides, 40, width, 8.0, 0.1, true, [&](const Eigen::Vector2d& p) {
        const double angle = 2.0 * std::numbers::pi * p.x() / width;
        return Eigen::Vector3d(std::cos(angle), std::sin(angle), p.y());
      });
  const LogMap map = computeLogMap(tube.mesh, surfacePointAtVertex(tube.mesh, 20 * kSides + 7),
                                   Eigen::Vector3d::UnitZ(), kEverything);
  const LogMapInverse inverse(tube.mesh, map);
  EXPECT_TRUE(inverse.at({0.0, 0.45 * width}).point.valid());
  const LogMapInverse::Place behind = inverse.at({0.0, 0.55 * width});
  EXPECT_FALSE(behind.point.valid());
  EXPECT_EQ(behind.reason, Unreachable::kCutLocus);
}

}  // namespace
}  // namespace handgraft::geometry
