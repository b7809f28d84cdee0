#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>
#include <random>

#include <gtest/gtest.h>

#include "core/geometry/log_map.h"

#include "tests/core/geometry/sheet.h"
#include "tests/core/geometry/sphere_error.h"

namespace handgraft::geometry {
namespace {

constexpr double kEverything = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-9;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

LogMap exactMap(const TriangleMesh& mesh,
                const SurfacePoint& source,
                const Eigen::Vector3d& direction,
                double radius = kEverything) {
  return computeLogMap(mesh, source, direction, radius, LogMapMethod::kExact);
}

/// Inside a face, on an edge, at an inner and at a boundary vertex.
std::vector<SurfacePoint> sourcesOf(const TriangleMesh& mesh) {
  return {{mesh.faceCount() / 2 + 7, {0.2, 0.5, 0.3}},
          {mesh.faceCount() / 3 + 5, {0.0, 0.4, 0.6}},
          {0, {0.4, 0.0, 0.6}},
          surfacePointAtVertex(mesh, mesh.vertexCount() / 2 + 3),
          surfacePointAtVertex(mesh, 0),
          surfacePointAtVertex(mesh, 5)};
}

// === Closed forms

void expectIdentity(const test::Sheet& sheet) {
  const Eigen::Vector3d direction(0.3, 0.8, 0.1);
  const double azimuth = std::atan2(0.8, 0.3);
  for (const SurfacePoint& source : sourcesOf(sheet.mesh)) {
    const LogMap map = exactMap(sheet.mesh, source, direction);
    ASSERT_EQ(map.vertices.size(), sheet.flat.size());
    const Eigen::Vector2d origin = positionOf(sheet.mesh, source).head<2>();
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      const Eigen::Vector2d truth = Eigen::Rotation2Dd(-azimuth) * (sheet.flat[v] - origin);
      ASSERT_LT((logCoordinatesAtVertex(map, v) - truth).norm(), kExact) << v;
    }
  }
}

TEST(ExactLogMap, IsIdentityOnAPlane) {
  expectIdentity(test::makePlane());
}

TEST(ExactLogMap, IsIdentityOnARegularPlaneFullOfTies) {
  expectIdentity(test::makePlane(0.0));
}

TEST(ExactLogMap, IsIdentityOnAPlaneOfSlivers) {
  expectIdentity(test::makePlane(0.24, 0.01));
}

TEST(ExactLogMap, UnrollsACylinder) {
  const auto [sides, width, sheet] = test::makeTube(64, 30, 3.0, 0.2);
  for (const int source : {15 * sides + 20, 3 * sides, 20}) {
    const LogMap map =
        exactMap(sheet.mesh, surfacePointAtVertex(sheet.mesh, source), {0.0, 0.0, 1.0});
    for (int v = 0; v < sheet.mesh.vertexCount(); ++v) {
      Eigen::Vector2d truth = sheet.flat[v] - sheet.flat[source];
      truth.x() = std::remainder(truth.x(), width);
      ASSERT_NEAR(map.r[v], truth.norm(), kExact) << v;
      if (std::abs(truth.x()) > 0.499 * width) continue;  // both ways round are right
      const Eigen::Vector2d turned(truth.y(), -truth.x());
      ASSERT_LT((logCoordinatesAtVertex(map, v) - turned).norm(), kExact) << v;
    }
  }
}

TEST(ExactLogMap, MeetsTheLawOfCosinesAllAroundACone) {
  constexpr int kSides = 24;
  constexpr double kSlant = 1.3;
  // A fan of equal triangles about an apex; distances there unroll to the law of cosines.
  Eigen::Matrix3Xd vertices(3, 3 * kSides + 1);
  vertices.col(0) = Eigen::Vector3d::Zero();
  for (int ring = 0; ring < 3; ++ring) {
    const double s = kSlant * (ring + 1) / 3.0;
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * kPi * k / kSides;
      vertices.col(1 + ring * kSides + k) =
          s * Eigen::Vector3d(0.6 * std::cos(angle), 0.6 * std::sin(angle), -0.8);
    }
  }
  std::vector<int> corners;
  for (int k = 0; k < kSides; ++k) {
    const int next = (k + 1) % kSides;
    corners.insert(corners.end(), {0, 1 + k, 1 + next});
    for (int ring = 0; ring < 2; ++ring) {
      const int a = 1 + ring * kSides + k;
      const int b = 1 + ring * kSides + next;
      corners.insert(corners.end(), {a, a + kSides, b + kSides, a, b + kSides, b});
    }
  }
  const TriangleMesh cone(
      vertices,
      Eigen::Map<Eigen::Matrix3Xi>(corners.data(), 3, static_cast<int>(corners.size()) / 3));
  const double half_side = std::asin(0.6 * std::sin(kPi / kSides));
  const int source = 1 + kSides;  // on the middle ring
  const LogMap map = exactMap(cone, surfacePointAtVertex(cone, source), {0.6, 0.0, -0.8});
  const double a = cone.vertex(source).norm();
  int compared = 0;
  for (int v = 1; v < cone.vertexCount(); ++v) {
    const int steps = std::min((v - 1) % kSides, kSides - (v - 1) % kSides);
    const double angle = 2.0 * half_side * steps;
    const double b = cone.vertex(v).norm();
    const double r = std::sqrt(std::max(0.0, a * a + b * b - 2.0 * a * b * std::cos(angle)));
    // The chord has to stay above the lower rim, a polygon.
    if (std::max(a, b) > 0.99 * kSlant * std::cos(half_side)) continue;
    ASSERT_NEAR(map.r[v], r, kExact) << v;
    ++compared;
  }
  EXPECT_EQ(compared, 2 * kSides);
}

TEST(ExactLogMap, AgreesWithArcLengthOnASphere) {
  const test::SphereError error = test::errorOnASphere(
      test::mixedSourcesOnASphere(), [](const TriangleMesh& mesh, const SurfacePoint& source,
                                        const Eigen::Vector3d& direction, double radius) {
        return exactMap(mesh, source, direction, radius);
      });
  EXPECT_LT(error.r, 2e-4);
  EXPECT_LT(error.phi, 7e-4);
}

// === Against an oracle: every straight way through every short sequence of faces

/// Distances and departures from a vertex, by unfolding without any filter: each beam goes on
/// through both edges until `kDeepest` faces; every vertex but flat ones spreads anew.
class Unfolding {
 public:
  Unfolding(const TriangleMesh& mesh, int source) : mesh_(mesh) {
    // Straight ways between all pairs of vertices, then the shortest chain of them.
    const int n = mesh.vertexCount();
    direct_.setConstant(n, n, kEverything);
    for (int v = 0; v < n; ++v) {
      direct_(v, v) = 0.0;
      for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h)
        lookFrom(v, *h);
    }
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j)
          direct_(i, j) = std::min(direct_(i, j), direct_(i, k) + direct_(k, j));
      }
    }
    r = direct_.row(source);
  }

  Eigen::VectorXd r;

 private:
  static constexpr int kDeepest = 14;

  void lookFrom(int v, int h) {
    const int edge = TriangleMesh::next(h);
    const Eigen::Vector3d a = mesh_.vertex(mesh_.from(edge)) - mesh_.vertex(v);
    const Eigen::Vector3d b = mesh_.vertex(mesh_.to(edge)) - mesh_.vertex(v);
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    const Eigen::Vector2d right(a.norm(), 0.0);
    const Eigen::Vector2d left = b.norm() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    see(v, mesh_.from(edge), right.norm());
    see(v, mesh_.to(edge), left.norm());
    unfold(v, mesh_.twin(edge), left, right, left, right, 0);
  }

  void see(int from, int to, double r_straight) {
    direct_(from, to) = std::min(direct_(from, to), r_straight);
  }

  void unfold(int v,
              int h,
              const Eigen::Vector2d& left,
              const Eigen::Vector2d& right,
              const Eigen::Vector2d& left_ray,
              const Eigen::Vector2d& right_ray,
              int depth) {
    if (h < 0 || depth == kDeepest) return;
    const int apex = mesh_.to(TriangleMesh::next(h));
    // By the two distances, unlike the product.
    const double length = (right - left).norm();
    const double from_left = (mesh_.vertex(apex) - mesh_.vertex(mesh_.from(h))).norm();
    const double from_right = (mesh_.vertex(apex) - mesh_.vertex(mesh_.to(h))).norm();
    const double x =
        (from_left * from_left - from_right * from_right + length * length) / (2.0 * length);
    const double y = std::sqrt(std::max(0.0, from_left * from_left - x * x));
    const Eigen::Vector2d along = (right - left) / length;
    const Eigen::Vector2d p = left + x * along + y * Eigen::Vector2d(-along.y(), along.x());
    const bool beyond_left = cross(left_ray, p) > 0.0;
    const bool beyond_right = cross(p, right_ray) > 0.0;
    if (!beyond_left && !beyond_right) see(v, apex, p.norm());
    if (!beyond_right) {
      unfold(v, mesh_.twin(TriangleMesh::next(h)), p, right, beyond_left ? left_ray : p,
             right_ray, depth + 1);
    }
    if (!beyond_left) {
      unfold(v, mesh_.twin(TriangleMesh::previous(h)), left, p, left_ray,
             beyond_right ? right_ray : p, depth + 1);
    }
  }

  const TriangleMesh& mesh_;
  Eigen::MatrixXd direct_;
};

/// A rough sheet with saddles, bumps, and, if wanted, an irregular hole and a slit edge.
TriangleMesh roughSheet(unsigned seed, double height, bool with_holes) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-height, height);
  const test::Sheet flat =
      test::makeSheet(5, 5, 1.0, 1.0, 0.2, false, [&](const Eigen::Vector2d& p) {
        return Eigen::Vector3d(p.x(), p.y(), shake(random));
      });
  Eigen::Matrix3Xi faces = flat.mesh.faces();
  if (with_holes) {
    int kept = 0;
    for (int f = 0; f < faces.cols(); ++f) {
      if (random() % 6 != 0) faces.col(kept++) = flat.mesh.faces().col(f);
    }
    faces.conservativeResize(3, kept);
  }
  return {flat.mesh.vertices(), faces};
}

void expectOraclesDistances(const TriangleMesh& mesh, int source) {
  const Unfolding oracle(mesh, source);
  const LogMap map = exactMap(mesh, surfacePointAtVertex(mesh, source), {0.7, 0.4, 0.1});
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (std::isinf(oracle.r[v])) {
      EXPECT_TRUE(std::isnan(map.r[v])) << v;
    } else {
      EXPECT_NEAR(map.r[v], oracle.r[v], 1e-9) << "from " << source << " to " << v;
    }
  }
}

TEST(ExactLogMap, AgreesWithBruteForceOnRoughSheets) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    for (const int source : {0, 14, 21})
      expectOraclesDistances(roughSheet(seed, 0.02 * seed, false), source);
  }
}

TEST(ExactLogMap, AgreesWithBruteForceAroundHolesAndPinchedVertices) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    const TriangleMesh mesh = roughSheet(seed, 0.01 * seed, true);
    for (const int source : {7, 14, 21}) {
      if (mesh.outgoingBegin(source) == mesh.outgoingEnd(source)) continue;
      if (mesh.vertexNormals().col(source).cross(Eigen::Vector3d(0.7, 0.4, 0.1)).norm() < 0.1)
        continue;
      expectOraclesDistances(mesh, source);
    }
  }
}

TEST(ExactLogMap, GoesRoundAReflexCornerOfTheEdge) {
  // An L: from the end of one arm the other arm lies behind the corner at (1, 1).
  Eigen::Matrix3Xd vertices(3, 8);
  vertices << 0, 1, 2, 0, 1, 2, 0, 1,  //
      0, 0, 0, 1, 1, 1, 2, 2,          //
      0, 0, 0, 0, 0, 0, 0, 0;
  Eigen::Matrix3Xi faces(3, 6);
  faces << 0, 0, 1, 1, 3, 3,  //
      1, 4, 2, 5, 4, 7,       //
      4, 3, 5, 4, 7, 6;
  const LogMap map =
      exactMap({vertices, faces}, surfacePointAtVertex({vertices, faces}, 5), {-1.0, 0.0, 0.0});
  EXPECT_NEAR(map.r[4], 1.0, kExact);
  EXPECT_NEAR(map.r[7], 2.0, kExact);
  EXPECT_NEAR(map.r[6], 1.0 + std::sqrt(2.0), kExact);
  EXPECT_NEAR(map.r[3], 2.0, kExact);
  // Beyond the corner every path left along the first edge.
  EXPECT_NEAR(map.phi[6], map.phi[4], kExact);
  EXPECT_NEAR(map.phi[7], map.phi[4], kExact);
}

// === What must not matter

TEST(ExactLogMap, FollowsRotationScaleAndRenumbering) {
  const TriangleMesh mesh = roughSheet(4, 0.06, false);
  const int n = mesh.vertexCount();
  const Eigen::Vector3d direction(0.7, 0.4, 0.1);
  const LogMap one = exactMap(mesh, surfacePointAtVertex(mesh, 14), direction);
  Eigen::Affine3d X(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  X.scale(1e-3);
  const Eigen::Matrix3Xi reversed = (n - 1 - mesh.faces().array()).rowwise().reverse();
  const TriangleMesh moved((X * mesh.vertices().colwise().homogeneous()).rowwise().reverse(),
                           reversed);
  const LogMap two =
      exactMap(moved, surfacePointAtVertex(moved, n - 1 - 14), X.linear() * direction);
  for (int v = 0; v < n; ++v) {
    EXPECT_NEAR(one.r[v], 1e3 * two.r[n - 1 - v], kExact);
    EXPECT_LT(
        (logCoordinatesAtVertex(one, v) - 1e3 * logCoordinatesAtVertex(two, n - 1 - v)).norm(),
        1e-8);
  }
}

TEST(ExactLogMap, IsTheSameTwice) {
  const TriangleMesh mesh = roughSheet(9, 0.1, true);
  const SurfacePoint source{3, {0.2, 0.5, 0.3}};
  const LogMap one = exactMap(mesh, source, {0.7, 0.4, 0.1});
  const LogMap two = exactMap(mesh, source, {0.7, 0.4, 0.1});
  EXPECT_EQ(one.vertices, two.vertices);
  for (const int v : one.vertices)
    EXPECT_TRUE(one.r[v] == two.r[v] && one.phi[v] == two.phi[v]);
}

TEST(ExactLogMap, HasTheSameDiskWhateverTheRadiusAround) {
  // A small disk is the middle of a large one, rim included.
  const TriangleMesh mesh = roughSheet(5, 0.05, false);
  const SurfacePoint source{20, {0.2, 0.5, 0.3}};
  const LogMap all = exactMap(mesh, source, {0.7, 0.4, 0.1});
  for (const double radius : {0.1, 0.2, 0.4, 0.8}) {
    const LogMap map = exactMap(mesh, source, {0.7, 0.4, 0.1}, radius);
    const auto within = std::count_if(all.vertices.begin(), all.vertices.end(), [&](int v) {
      return all.r[v] <= radius;
    });
    EXPECT_EQ(std::ssize(map.vertices), within);
    for (const int v : map.vertices)
      EXPECT_NEAR(map.r[v], all.r[v], 1e-12);
    for (const LogMap::RimVertex& rim : map.rim)
      EXPECT_LT((rim.p_T - logCoordinatesAtVertex(all, rim.vertex)).norm(), kExact);
  }
}

TEST(ExactLogMap, AgreesWithFastOnAPlaneFromEverySource) {
  const test::Sheet sheet = test::makePlane();
  for (const SurfacePoint& source : sourcesOf(sheet.mesh)) {
    const LogMap exact = exactMap(sheet.mesh, source, {0.3, 0.8, 0.1}, 0.31);
    const LogMap fast = computeLogMap(sheet.mesh, source, {0.3, 0.8, 0.1}, 0.31);
    EXPECT_EQ(exact.faces, fast.faces);
    EXPECT_EQ(exact.rim_faces, fast.rim_faces);
    ASSERT_EQ(exact.vertices.size(), fast.vertices.size());
    ASSERT_EQ(exact.rim.size(), fast.rim.size());
    for (std::size_t i = 0; i < exact.rim.size(); ++i)
      EXPECT_LT((exact.rim[i].p_T - fast.rim[i].p_T).norm(), kExact);
    for (const int v : exact.vertices) {
      EXPECT_LT((logCoordinatesAtVertex(exact, v) - logCoordinatesAtVertex(fast, v)).norm(),
                kExact);
    }
  }
}

TEST(ExactLogMap, SharesFastsAnglesAroundABoxCorner) {
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  const LogMap map = exactMap(box, surfacePointAtVertex(box, 7), {-1.0, 0.0, 0.0}, 1.1);
  EXPECT_NEAR(map.phi[6], 0.0, 1e-12);
  EXPECT_NEAR(std::abs(map.phi[5]), 2.0 * kPi / 3.0, 1e-12);
  EXPECT_NEAR(map.phi[3], -map.phi[5], 1e-12);
}

// === Bad meshes

TEST(ExactLogMap, CrossesFacesWithoutArea) {
  // A plane cut along x = 1, joined again by a face of three points on that line.
  Eigen::Matrix3Xd vertices(3, 7);
  vertices << 0, 0, 1, 1, 1, 2, 2,  //
      0, 2, 0, 1, 2, 0, 2,          //
      0, 0, 0, 0, 0, 0, 0;
  Eigen::Matrix3Xi faces(3, 6);
  faces << 0, 0, 4, 2, 5, 4,  //
      2, 4, 2, 5, 6, 3,       //
      4, 1, 3, 3, 3, 6;
  const TriangleMesh mesh(vertices, faces);
  const LogMap map = exactMap(mesh, surfacePointAtVertex(mesh, 0), {1.0, 0.0, 0.0});
  for (int v = 1; v < 7; ++v) {
    EXPECT_LT((logCoordinatesAtVertex(map, v) - mesh.vertex(v).head<2>()).norm(), kExact) << v;
  }
}

TEST(ExactLogMap, SurvivesAnyTriangleSoup) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  int maps = 0;
  for (int repeat = 0; repeat < 60; ++repeat) {
    Eigen::Matrix3Xd vertices(3, 12);
    for (double& x : vertices.reshaped())
      x = repeat % 3 == 0 ? std::round(2.0 * place(random)) : place(random);
    Eigen::Matrix3Xi faces(3, 40);
    for (int f = 0; f < 40; ++f) {
      do {
        for (int c = 0; c < 3; ++c)
          faces(c, f) = static_cast<int>(random() % 12);
      } while (faces(0, f) == faces(1, f) || faces(1, f) == faces(2, f) ||
               faces(2, f) == faces(0, f));
    }
    const TriangleMesh mesh(vertices, faces);
    for (int f = 0; f < 40; f += 3) {
      const SurfacePoint source{f, {0.2, 0.5, 0.3}};
      if (mesh.faceNormals().col(f).isZero(0.0)) continue;
      for (const LogMapMethod method : {LogMapMethod::kExact, LogMapMethod::kAuto}) {
        const LogMap map = computeLogMap(
            mesh, source, mesh.faceNormals().col(f).unitOrthogonal(), kEverything, method);
        ++maps;
        for (const int v : map.vertices) {
          ASSERT_TRUE(std::isfinite(map.r[v]) && std::isfinite(map.phi[v]));
          ASSERT_GE(map.r[v], (mesh.vertex(v) - positionOf(mesh, source)).norm() - kExact);
        }
      }
    }
  }
  EXPECT_GT(maps, 500);
}

// === auto

TEST(AutoLogMap, IsExactOnSmoothDisksAndSaysSo) {
  const TriangleMesh sphere = makeSphere(1.0, 4);
  const SurfacePoint source{77, {0.2, 0.5, 0.3}};
  const LogMap map = computeLogMap(sphere, source, {0.3, 0.8, 0.4}, 0.6, LogMapMethod::kAuto);
  EXPECT_EQ(map.method, LogMapMethod::kExact);
  EXPECT_EQ(computeLogMap(sphere, source, {0.3, 0.8, 0.4}, 0.6).method, LogMapMethod::kFast);
  EXPECT_EQ(map.vertices, exactMap(sphere, source, {0.3, 0.8, 0.4}, 0.6).vertices);
}

TEST(AutoLogMap, IsNeverLessSoundThanFast) {
  const auto unsound = [](const TriangleMesh& mesh, const LogMap& map) {
    int count = 0;
    for (const int f : map.faces) {
      const Eigen::Vector2d a = logCoordinatesAtVertex(map, mesh.faces()(0, f));
      const Eigen::Vector2d b = logCoordinatesAtVertex(map, mesh.faces()(1, f));
      const Eigen::Vector2d c = logCoordinatesAtVertex(map, mesh.faces()(2, f));
      const double area =
          (mesh.vertex(mesh.faces()(1, f)) - mesh.vertex(mesh.faces()(0, f)))
              .cross(mesh.vertex(mesh.faces()(2, f)) - mesh.vertex(mesh.faces()(0, f)))
              .norm();
      count += cross(b - a, c - a) <= 0.5 * area;
    }
    return count;
  };
  int fell_back = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TriangleMesh mesh = roughSheet(seed, 0.1, false);
    const SurfacePoint source{24, {0.2, 0.5, 0.3}};
    const Eigen::Vector3d direction = mesh.faceNormals().col(24).unitOrthogonal();
    const LogMap chosen =
        computeLogMap(mesh, source, direction, kEverything, LogMapMethod::kAuto);
    const LogMap fast = computeLogMap(mesh, source, direction, kEverything);
    const LogMap exact = exactMap(mesh, source, direction);
    EXPECT_EQ(unsound(mesh, chosen), std::min(unsound(mesh, fast), unsound(mesh, exact)));
    fell_back += chosen.method == LogMapMethod::kFast;
  }
  EXPECT_GT(fell_back, 0);
}

TEST(LogMapMethod, RoundTripsItsNames) {
  for (const LogMapMethod method :
       {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto}) {
    EXPECT_EQ(logMapMethodFrom(nameOf(method)), method);
  }
}

}  // namespace
}  // namespace handgraft::geometry
