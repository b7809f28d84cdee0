#include "core/geometry/signed_distance.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/closed_surface.h"

#include "tests/core/geometry/solids.h"

namespace handgraft::geometry {
namespace {

using Eigen::Vector3d;
using test::makeTorus;
using test::randomIn;

double boxDistance(const Vector3d& p, const Vector3d& size) {
  const Vector3d q = p.cwiseAbs() - 0.5 * size;
  return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
}

TriangleMesh withFaces(const TriangleMesh& mesh, const std::vector<Eigen::Vector3i>& faces) {
  Eigen::Matrix3Xi columns(3, static_cast<Eigen::Index>(faces.size()));
  for (Eigen::Index f = 0; f < columns.cols(); ++f)
    columns.col(f) = faces[static_cast<std::size_t>(f)];
  return {mesh.vertices(), columns};
}

/// Each face looks to a side drawn at random.
TriangleMesh shuffledSides(const TriangleMesh& mesh, std::mt19937& random) {
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    Eigen::Vector3i face = mesh.face(f);
    if (random() % 3 == 0) std::swap(face[1], face[2]);
    faces.push_back(face);
  }
  return withFaces(mesh, faces);
}

/// How many faces a ray from p meets: odd inside any closed mesh, whatever its orientation.
bool isInsideByParity(const TriangleMesh& mesh, const Vector3d& p, const Vector3d& direction) {
  bool inside = false;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Vector3d a = mesh.vertex(mesh.face(f)[0]);
    const Vector3d ab = mesh.vertex(mesh.face(f)[1]) - a;
    const Vector3d ac = mesh.vertex(mesh.face(f)[2]) - a;
    const Vector3d h = direction.cross(ac);
    const double determinant = ab.dot(h);
    const Vector3d s = p - a;
    const double u = s.dot(h) / determinant;
    const Vector3d q = s.cross(ab);
    const double v = direction.dot(q) / determinant;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0) inside = !inside;
  }
  return inside;
}

TEST(SignedDistance, IsABoxsClosedForm) {
  const Vector3d size(0.1, 0.06, 0.03);
  const SignedDistance distance(makeBox(size));
  std::mt19937 random(1);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = randomIn(0.08, random);
    EXPECT_NEAR(distance.at(p).distance, boxDistance(p, size), 1e-14) << p.transpose();
  }
}

TEST(SignedDistance, IsASpheresClosedFormWithinItsFacets) {
  const double radius = 0.04;
  const SignedDistance distance(makeSphere(radius, 5));
  const double facets = 5e-5;  // m, how far the middle of a face lies below the sphere, or less
  std::mt19937 random(2);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = randomIn(0.06, random);
    EXPECT_NEAR(distance.at(p).distance, p.norm() - radius, facets);
  }
}

TEST(SignedDistance, IsATorusClosedFormWithinItsFacets) {
  const SignedDistance distance(makeTorus(0.05, 0.015, 160, 80));
  std::mt19937 random(3);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = randomIn(0.08, random);
    const double around = std::hypot(p.x(), p.y()) - 0.05;
    EXPECT_NEAR(distance.at(p).distance, std::hypot(around, p.z()) - 0.015, 3e-5);
  }
}

TEST(SignedDistance, HasTheSignThatRaysCountAtOneHundredThousandPlaces) {
  const TriangleMesh mesh = makeTorus(0.05, 0.02, 24, 12);
  const SignedDistance distance(mesh);
  const Vector3d direction = Vector3d(0.3123, 0.5437, 0.7791).normalized();
  std::mt19937 random(4);
  int inside = 0;
  for (int k = 0; k < 100000; ++k) {
    const Vector3d p = randomIn(0.07, random);
    const bool expected = isInsideByParity(mesh, p, direction);
    inside += expected ? 1 : 0;
    // Through an edge a ray counts two faces or none.
    if (distance.contains(p) == expected) continue;
    EXPECT_EQ(distance.contains(p), isInsideByParity(mesh, p, Vector3d(-0.61, 0.17, 0.33)))
        << p.transpose();
  }
  EXPECT_GT(inside, 5000);
}

TEST(SignedDistance, HasTheGradientOfItsDifferences) {
  const SignedDistance distance(makeBox({0.1, 0.06, 0.03}));
  std::mt19937 random(5);
  int judged = 0;
  for (int k = 0; k < 500; ++k) {
    const Vector3d p = randomIn(0.08, random);
    const SignedDistance::Sample here = distance.at(p);
    Vector3d difference;
    const double step = 1e-6;
    for (int a = 0; a < 3; ++a) {
      const Vector3d way = step * Vector3d::Unit(a);
      difference[a] = (distance.at(p + way).distance - distance.at(p - way).distance) / 2e-6;
    }
    // Across a ridge inside, where two faces are equally near, there is none.
    if (std::abs(difference.norm() - 1.0) > 1e-3) continue;
    ++judged;
    EXPECT_LT((here.gradient - difference).norm(), 1e-4) << p.transpose();
    EXPECT_NEAR((p - here.nearest).norm(), std::abs(here.distance), 1e-15);
  }
  EXPECT_GT(judged, 450);
}

TEST(SignedDistance, DoesNotMindWhichWayFacesLook) {
  std::mt19937 random(6);
  const TriangleMesh mesh = makeTorus(0.05, 0.02, 24, 12);
  const SignedDistance tidy(mesh);
  const SignedDistance untidy(shuffledSides(mesh, random));
  Eigen::Matrix3Xi turned = mesh.faces();
  turned.row(1).swap(turned.row(2));
  const SignedDistance inside_out(TriangleMesh(mesh.vertices(), turned));
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = randomIn(0.07, random);
    EXPECT_NEAR(untidy.at(p).distance, tidy.at(p).distance, 1e-15);
    EXPECT_NEAR(inside_out.at(p).distance, tidy.at(p).distance, 1e-15);
  }
}

TEST(SignedDistance, ShutsAFlatHoleAsIfItHadNeverBeen) {
  const Vector3d size(0.1, 0.06, 0.03);
  const TriangleMesh box = makeBox(size);
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < box.faceCount(); ++f)
    if (box.faceNormals().col(f).z() < 0.5) faces.push_back(box.face(f));
  ASSERT_EQ(faces.size(), 10u);
  const SignedDistance open(withFaces(box, faces));
  std::mt19937 random(7);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = randomIn(0.08, random);
    EXPECT_NEAR(open.at(p).distance, boxDistance(p, size), 1e-14);
  }
}

TEST(SignedDistance, JoinsFacesThatShareNoVertex) {
  const Vector3d size(0.1, 0.06, 0.03);
  const TriangleMesh box = makeBox(size);
  Eigen::Matrix3Xd vertices(3, 36);
  Eigen::Matrix3Xi faces(3, 12);
  for (int i = 0; i < 36; ++i) {
    vertices.col(i) = box.vertex(box.face(i / 3)[i % 3]);
    faces(i % 3, i / 3) = i;
  }
  const TriangleMesh loose(vertices, faces);
  EXPECT_EQ(closedSurface(loose).faceCount(), 12);
  EXPECT_NEAR(SignedDistance(loose).at({0, 0, 0.01}).distance, -0.005, 1e-15);
}

TEST(SignedDistance, TakesOverlappingSolidsForOneAndCavitiesForEmpty) {
  const auto moved_box = [](double x) {
    return transformed(makeBox({0.04, 0.04, 0.04}),
                       Eigen::Affine3d(Eigen::Translation3d(x, 0, 0)));
  };
  const SignedDistance both(merged({moved_box(-0.01), moved_box(0.01)}));
  const TriangleMesh inner = makeBox({0.02, 0.02, 0.02});
  Eigen::Matrix3Xi turned = inner.faces();
  turned.row(1).swap(turned.row(2));
  const SignedDistance hollow(
      merged({makeBox({0.04, 0.04, 0.04}), TriangleMesh(inner.vertices(), turned)}));
  std::mt19937 random(8);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = randomIn(0.04, random);
    const bool in_outer = p.cwiseAbs().maxCoeff() < 0.02;
    EXPECT_EQ(hollow.contains(p), in_outer && p.cwiseAbs().maxCoeff() > 0.01);
    const bool in_both =
        std::abs(p.x()) < 0.03 && std::abs(p.y()) < 0.02 && std::abs(p.z()) < 0.02;
    EXPECT_EQ(both.contains(p), in_both) << p.transpose();
  }
}

TEST(SignedDistance, LeavesOutWallsWithinOverlappingSolids) {
  const auto ball_at = [](double x) {
    return transformed(makeSphere(0.04, 4), Eigen::Affine3d(Eigen::Translation3d(x, 0, 0)));
  };
  const SignedDistance with_walls(merged({ball_at(-0.015), ball_at(0.015)}));
  const SignedDistance without = with_walls.withoutInnerWalls(5e-4);
  // Of two balls, 30 mm apart, the deepest place is as far from the circle where they meet.
  EXPECT_NEAR(with_walls.at(Vector3d::Zero()).distance, -0.025, 2e-4);
  EXPECT_NEAR(without.at(Vector3d::Zero()).distance, -std::sqrt(0.04 * 0.04 - 0.015 * 0.015),
              0.003);  // a facet: those that cross the circle stay
  std::mt19937 random(7);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d p = randomIn(0.07, random);
    const double before = with_walls.at(p).distance;
    const double after = without.at(p).distance;
    EXPECT_EQ(without.contains(p), with_walls.contains(p));
    if (before > 0.0) {
      EXPECT_NEAR(after, before, 4e-4) << p.transpose();  // a piece of a facet
    } else {
      EXPECT_LE(after, before + 1e-12) << p.transpose();
    }
  }
}

TEST(SignedDistance, KeepsWallsOfCavities) {
  const TriangleMesh inner = makeSphere(0.02, 3);
  Eigen::Matrix3Xi turned = inner.faces();
  turned.row(1).swap(turned.row(2));
  const SignedDistance hollow(
      merged({makeSphere(0.04, 3), TriangleMesh(inner.vertices(), turned)}));
  EXPECT_EQ(hollow.withoutInnerWalls(5e-4).surface().faceCount(), hollow.surface().faceCount());
}

TEST(SignedDistance, IsContinuousOnAMeshWithHolesAndEdgesOfThreeFaces) {
  // Every fifth face is missing, one edge has a fin.
  const TriangleMesh sphere = makeSphere(0.04, 3);
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < sphere.faceCount(); ++f)
    if (f % 5 != 0) faces.push_back(sphere.face(f));
  faces.emplace_back(faces[0][0], faces[0][1], faces[300][2]);
  const SignedDistance distance(withFaces(sphere, faces));
  std::mt19937 random(9);
  for (int k = 0; k < 20000; ++k) {
    const Vector3d p = randomIn(0.06, random);
    const Vector3d q = p + randomIn(5e-4, random);
    EXPECT_LE(std::abs(distance.at(p).distance - distance.at(q).distance),
              (p - q).norm() + 1e-12);
  }
  EXPECT_LT(distance.at(Vector3d::Zero()).distance, -0.03);
}

TEST(SignedDistance, RefusesWhatHasNoSurface) {
  EXPECT_THROW(static_cast<void>(SignedDistance(TriangleMesh{})), InvalidInput);
  EXPECT_THROW(static_cast<void>(SignedDistance(makeBox({1, 1, 1})).at({NAN, 0, 0})),
               InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
