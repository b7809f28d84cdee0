#include "core/geometry/triangle_mesh.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_point.h"

namespace handgraft::geometry {
namespace {

double signedVolume(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i t = mesh.face(f);
    volume += mesh.vertex(t[0]).dot(mesh.vertex(t[1]).cross(mesh.vertex(t[2]))) / 6.0;
  }
  return volume;
}

TEST(TriangleMesh, PrimitivesAreClosedAndLookOutwards) {
  for (const TriangleMesh& mesh :
       {makeBox({1, 2, 3}), makeCylinder(0.5, 2.0, 64), makeSphere(1.0, 3)}) {
    EXPECT_TRUE(mesh.isClosed());
    EXPECT_EQ(mesh.eulerCharacteristic(), 2);
    EXPECT_EQ(mesh.components().second, 1);
    EXPECT_GT(signedVolume(mesh), 0.0);
  }
  EXPECT_NEAR(signedVolume(makeBox({1, 2, 3})), 6.0, 1e-12);
  EXPECT_NEAR(makeBox({1, 2, 3}).area(), 22.0, 1e-12);
  EXPECT_EQ(makeSphere(1.0, 5).vertexCount(), 10242);
  EXPECT_NEAR(makeSphere(1.0, 5).area(), 4.0 * std::numbers::pi, 0.02);
}

TEST(TriangleMesh, TwinsAreMutualAndRunTheOtherWay) {
  const TriangleMesh mesh = makeSphere(1.0, 2);
  for (int h = 0; h < 3 * mesh.faceCount(); ++h) {
    ASSERT_EQ(mesh.twin(mesh.twin(h)), h);
    ASSERT_EQ(mesh.from(h), mesh.to(mesh.twin(h)));
  }
}

TEST(TriangleMesh, NonManifoldEdgesHaveNoTwins) {
  Eigen::Matrix3Xd vertices = Eigen::Matrix3Xd::Random(3, 5);
  Eigen::Matrix3Xi three(3, 3);
  three << 0, 1, 0, 1, 0, 1, 2, 3, 4;
  const TriangleMesh book(vertices, three);
  EXPECT_EQ(book.nonManifoldEdgeCount(), 1);
  EXPECT_EQ(book.twin(0), -1);
  Eigen::Matrix3Xi disagreeing(3, 2);
  disagreeing << 0, 0, 1, 1, 2, 3;
  EXPECT_EQ(TriangleMesh(vertices, disagreeing).nonManifoldEdgeCount(), 1);
}

TEST(TriangleMesh, FacesWithoutAreaHaveNoNormal) {
  Eigen::Matrix3Xd vertices(3, 4);
  vertices << 0, 1, 2, 9, 0, 0, 0, 9, 0, 0, 0, 9;
  const TriangleMesh mesh(vertices, Eigen::Vector3i(0, 1, 2));
  EXPECT_TRUE(mesh.faceNormals().isZero(0.0));
  EXPECT_TRUE(mesh.vertexNormals().isZero(0.0));
  EXPECT_EQ(mesh.components().second, 2);
  EXPECT_FALSE(mesh.isBoundaryVertex(3));
}

TEST(TriangleMesh, RefusesWrongInputAndNamesIt) {
  Eigen::Matrix3Xd vertices = Eigen::Matrix3Xd::Zero(3, 3);
  EXPECT_THROW(TriangleMesh(vertices, Eigen::Vector3i(0, 1, 3)), InvalidInput);
  EXPECT_THROW(TriangleMesh(vertices, Eigen::Vector3i(0, -1, 2)), InvalidInput);
  EXPECT_THROW(TriangleMesh(vertices, Eigen::Vector3i(0, 1, 1)), InvalidInput);
  vertices(0, 2) = std::nan("");
  try {
    TriangleMesh(vertices, Eigen::Vector3i(0, 1, 2));
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "vertex 2 is (nan, 0, 0), coordinates must be finite");
  }
  EXPECT_THROW(makeBox({1.0, 0.0, 1.0}), InvalidInput);
  EXPECT_THROW(makeSphere(1.0, 20), InvalidInput);
}

TEST(TriangleMesh, AMirrorTurnsTheFacesRound) {
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 2.0, 1.0));
  EXPECT_NEAR(signedVolume(transformed(makeBox({1, 1, 1}), mirror)), 2.0, 1e-12);
}

TEST(SurfacePoint, StandsOnAVertexOrNot) {
  const TriangleMesh box = makeBox({1, 1, 1});
  for (int v = 0; v < 8; ++v) {
    const SurfacePoint point = surfacePointAtVertex(box, v);
    EXPECT_EQ(vertexAt(box, point), v);
    EXPECT_EQ(positionOf(box, point), box.vertex(v));
    EXPECT_NEAR(normalOf(box, point).dot(box.vertex(v).normalized()), 1.0, 1e-9);
  }
  EXPECT_EQ(vertexAt(box, {0, {0.5, 0.5, 0.0}}), -1);
  EXPECT_THROW(surfacePointAtVertex(box, 8), InvalidInput);
  EXPECT_THROW(validate(box, {0, {0.5, 0.6, 0.0}}, "root"), InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
