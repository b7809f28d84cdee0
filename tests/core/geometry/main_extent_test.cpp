#include "core/geometry/main_extent.h"

#include <gtest/gtest.h>

namespace handgraft::geometry {
namespace {

/// `mesh`, and a triangle of 1 mm far from it.
TriangleMesh withASpeck(const TriangleMesh& mesh, double away) {
  const Eigen::Index count = mesh.vertices().cols();
  Eigen::Matrix3Xd vertices(3, count + 3);
  vertices.leftCols(count) = mesh.vertices();
  vertices.rightCols<3>().setConstant(away);
  vertices(0, count + 1) += 1e-3;
  vertices(1, count + 2) += 1e-3;
  Eigen::Matrix3Xi faces(3, mesh.faces().cols() + 1);
  faces.leftCols(mesh.faces().cols()) = mesh.faces();
  const int first = static_cast<int>(count);
  faces.rightCols<1>() << first, first + 1, first + 2;
  return {vertices, faces};
}

TEST(MainExtent, IsThatOfTheBoxAsARule) {
  const TriangleMesh box = makeBox({0.1, 0.2, 0.2});
  EXPECT_DOUBLE_EQ(mainExtent(box), 0.3);
  const TriangleMesh rod = makeCylinder(0.001, 0.3);
  EXPECT_DOUBLE_EQ(mainExtent(rod), rod.diagonal());
  EXPECT_EQ(mainExtent(Eigen::Matrix3Xd(3, 0)), 0.0);
}

TEST(MainExtent, LeavesOutASpeckFarAway) {
  const TriangleMesh ball = makeSphere(0.05);
  const TriangleMesh scan = withASpeck(ball, 4.0);
  EXPECT_GT(scan.diagonal(), 6.0);
  EXPECT_NEAR(mainExtent(scan), ball.diagonal(), 0.1 * ball.diagonal());
  EXPECT_NEAR(mainExtent(scan.vertices()), ball.diagonal(), 0.1 * ball.diagonal());
}

TEST(MainExtent, CountsASpeckThatIsNear) {
  const TriangleMesh scan = withASpeck(makeSphere(0.05), 0.06);
  EXPECT_DOUBLE_EQ(mainExtent(scan), scan.diagonal());
}

}  // namespace
}  // namespace handgraft::geometry
