#include "core/geometry/intrinsic_delaunay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/geometry/sheet.h"

namespace handgraft::geometry {
namespace {

constexpr double kPi = std::numbers::pi;

/// Closed, and far from Delaunay: a sphere flattened to a tenth along z.
TriangleMesh makeFlattenedSphere() {
  return transformed(makeSphere(0.05, 4), Eigen::Affine3d(Eigen::Scaling(1.0, 1.0, 0.1)));
}

std::vector<TriangleMesh> hardMeshes() {
  return {makeFlattenedSphere(), test::makePlane(0.24, 0.01).mesh, test::makePlane().mesh,
          makeCylinder(0.01, 0.3, 200), makeBox({1.0, 0.1, 0.01})};
}

TEST(IntrinsicDelaunay, MakesEveryEdgeDelaunay) {
  for (const TriangleMesh& mesh : hardMeshes()) {
    const IntrinsicDelaunay surface(mesh);
    ASSERT_EQ(surface.faceCount(), mesh.faceCount());
    for (int h = 0; h < surface.halfedgeCount(); ++h) {
      EXPECT_TRUE(surface.isDelaunay(h));
      if (surface.twin(h) < 0) continue;
      EXPECT_GE(surface.cotanWeight(h), -1e-6);
      EXPECT_EQ(surface.twin(surface.twin(h)), h);
      EXPECT_EQ(surface.from(surface.twin(h)), surface.to(h));
      EXPECT_EQ(surface.length(surface.twin(h)), surface.length(h));
    }
  }
  EXPECT_GT(IntrinsicDelaunay(makeFlattenedSphere()).flipCount(), 100);
}

TEST(IntrinsicDelaunay, KeepsAreaAndAngles) {
  for (const TriangleMesh& mesh : hardMeshes()) {
    const IntrinsicDelaunay surface(mesh);
    double area = 0.0;
    std::vector<double> angle_sums(static_cast<std::size_t>(mesh.vertexCount()), 0.0);
    for (int h = 0; h < surface.halfedgeCount(); ++h) {
      angle_sums[surface.from(h)] += surface.cornerAngle(h);
      if (h % 3 == 0) area += surface.area(h / 3);
    }
    EXPECT_NEAR(area, mesh.area(), 1e-10 * mesh.area());
    for (int v = 0; v < mesh.vertexCount(); ++v)
      EXPECT_NEAR(angle_sums[v], mesh.angleSum(v), 1e-8) << v;
  }
}

TEST(IntrinsicDelaunay, KeepsTheTotalCurvature) {
  for (const TriangleMesh& mesh : {makeFlattenedSphere(), makeCylinder(0.01, 0.3, 200)}) {
    const IntrinsicDelaunay surface(mesh);
    double curvature = 2.0 * kPi * mesh.vertexCount();
    for (int h = 0; h < surface.halfedgeCount(); ++h)
      curvature -= surface.cornerAngle(h);
    EXPECT_NEAR(curvature, 4.0 * kPi, 1e-8);
  }
}

TEST(IntrinsicDelaunay, KeepsAPlaneFlat) {
  const test::Sheet sheet = test::makePlane(0.24, 0.01);
  const IntrinsicDelaunay surface(sheet.mesh);
  ASSERT_GT(surface.flipCount(), 100);
  std::vector<std::complex<double>> turns(sheet.flat.size(), 0.0);
  for (int h = 0; h < surface.halfedgeCount(); ++h) {
    const Eigen::Vector2d edge = sheet.flat[surface.to(h)] - sheet.flat[surface.from(h)];
    EXPECT_NEAR(surface.length(h), edge.norm(), 1e-12);
    // Signposts keep their directions: all edges of a vertex are turned by one angle.
    const std::complex<double> turn =
        surface.direction(h) / (std::complex<double>(edge.x(), edge.y()) / edge.norm());
    std::complex<double>& first = turns[surface.from(h)];
    if (first == 0.0) first = turn;
    EXPECT_LT(std::abs(turn - first), 1e-9);
    const std::complex<double> back =
        surface.directionBack(h) / (-std::complex<double>(edge.x(), edge.y()) / edge.norm());
    std::complex<double>& other = turns[surface.to(h)];
    if (other == 0.0) other = back;
    EXPECT_LT(std::abs(back - other), 1e-9);
  }
}

TEST(IntrinsicDelaunay, LeavesADelaunayMeshAlone) {
  EXPECT_EQ(IntrinsicDelaunay(makeSphere(1.0, 3)).flipCount(), 0);
}

TEST(IntrinsicDelaunay, NamesWhatItCannotTriangulate) {
  Eigen::Matrix3Xd vertices(3, 5);
  vertices << 0, 1, 0, -1, 0,  //
      0, 0, 1, 0, -1,          //
      0, 0, 0, 0, 1;
  // Two triangles that share nothing but vertex 0.
  Eigen::Matrix3Xi pinched(3, 2);
  pinched << 0, 0, 1, 3, 2, 4;
  // Three faces on the edge between vertices 0 and 1.
  Eigen::Matrix3Xi fin(3, 3);
  fin << 0, 1, 0, 1, 0, 1, 2, 3, 4;
  // Two faces that disagree on what is outside.
  Eigen::Matrix3Xi turned(3, 2);
  turned << 0, 0, 1, 1, 2, 3;
  // Vertices 1, 0, 3 on one line.
  Eigen::Matrix3Xi line(3, 1);
  line << 1, 0, 3;
  for (const Eigen::Matrix3Xi& faces : {pinched, fin, turned, line}) {
    const TriangleMesh mesh(vertices, faces);
    EXPECT_THROW(IntrinsicDelaunay{mesh}, InvalidInput);
  }
  EXPECT_NE(defectOfVertex(TriangleMesh(vertices, pinched), 0).find("vertex 0"),
            std::string::npos);
  EXPECT_NE(defectOfFace(TriangleMesh(vertices, line), 0).find("face 0"), std::string::npos);
  EXPECT_TRUE(defectOfVertex(TriangleMesh(vertices, pinched), 1).empty());
}

}  // namespace
}  // namespace handgraft::geometry
