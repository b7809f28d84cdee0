#include "core/cloud/pinholes.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::cloud {
namespace {

using geometry::TriangleMesh;

TriangleMesh without(const TriangleMesh& mesh, const std::vector<int>& left_out) {
  Eigen::Matrix3Xi faces(3, mesh.faceCount() - std::ssize(left_out));
  Eigen::Index count = 0;
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (std::find(left_out.begin(), left_out.end(), f) == left_out.end())
      faces.col(count++) = mesh.face(f);
  return {mesh.vertices(), faces};
}

std::vector<int> facesAt(const TriangleMesh& mesh, int v) {
  std::vector<int> faces;
  for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h)
    faces.push_back(TriangleMesh::faceOf(*h));
  return faces;
}

TEST(Pinholes, ClosesAHoleTheWayTheSurfaceLooks) {
  const TriangleMesh sphere = geometry::makeSphere(1.0, 3);
  const TriangleMesh holed = without(sphere, facesAt(sphere, 5));
  ASSERT_EQ(borderLoops(holed).size(), 1u);
  const Mended mended = closePinholes(holed, 1.0);
  EXPECT_EQ(mended.closed, 1);
  EXPECT_TRUE(mended.mesh.isClosed());
  EXPECT_EQ(mended.mesh.eulerCharacteristic(), 2);
  for (int f = 0; f < mended.mesh.faceCount(); ++f)
    EXPECT_GT(mended.mesh.faceNormals().col(f).dot(mended.mesh.vertex(mended.mesh.face(f)[0])),
              0.0);
}

TEST(Pinholes, ClosesTwoHolesThatTouch) {
  const TriangleMesh sphere = geometry::makeSphere(1.0, 2);
  const std::vector<int> around = facesAt(sphere, 40);
  ASSERT_EQ(around.size(), 6u);
  // Two faces of the ring that share nothing but its middle.
  int other = -1;
  for (const int f : around) {
    int shared = 0;
    for (const int v : sphere.face(f))
      for (const int w : sphere.face(around[0]))
        shared += static_cast<int>(v == w);
    if (shared == 1) other = f;
  }
  const TriangleMesh holed = without(sphere, {around[0], other});
  EXPECT_EQ(borderLoops(holed).size(), 2u);
  EXPECT_TRUE(closePinholes(holed, 1.0).mesh.isClosed());
}

TEST(Pinholes, LeavesWideHoles) {
  const TriangleMesh sphere = geometry::makeSphere(1.0, 3);
  const TriangleMesh holed = without(sphere, facesAt(sphere, 5));
  const double width = widthOf(holed, borderLoops(holed).front());
  EXPECT_EQ(closePinholes(holed, 0.99 * width).closed, 0);
  EXPECT_EQ(closePinholes(holed, 1.01 * width).closed, 1);
}

}  // namespace
}  // namespace handgraft::cloud
