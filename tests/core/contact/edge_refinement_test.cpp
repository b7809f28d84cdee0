#include "core/contact/edge_refinement.h"

#include <algorithm>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

double longestEdge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (int h = 0; h < 3 * mesh.faceCount(); ++h)
    longest = std::max(longest, (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).norm());
  return longest;
}

/// Of all corners, in radians.
double smallestAngle(const TriangleMesh& mesh) {
  double smallest = 4.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d a = mesh.vertex(mesh.face(f)[i]);
      const Eigen::Vector3d u = mesh.vertex(mesh.face(f)[(i + 1) % 3]) - a;
      const Eigen::Vector3d v = mesh.vertex(mesh.face(f)[(i + 2) % 3]) - a;
      smallest = std::min(smallest, std::acos(u.dot(v) / (u.norm() * v.norm())));
    }
  }
  return smallest;
}

TEST(RefineEdges, KeepsTheSurfaceClosedAndItsArea) {
  const TriangleMesh box = geometry::makeBox({0.16, 0.05, 0.21});
  const TriangleMesh fine = refineEdges(box, 0.004);
  EXPECT_LE(longestEdge(fine), 0.004);
  EXPECT_TRUE(fine.isClosed());
  EXPECT_EQ(fine.nonManifoldEdgeCount(), 0);
  EXPECT_EQ(fine.eulerCharacteristic(), 2);
  EXPECT_NEAR(fine.area(), box.area(), 1e-12);
  EXPECT_EQ(fine.vertices().leftCols(8), box.vertices());
}

TEST(RefineEdges, CutsNoFaceThinnerThanHalfOfWhatItWas) {
  // Cutting from the middle of the longest edge halves the smallest angle at worst
  // (Rosenberg & Stenger 1975).
  const TriangleMesh box = geometry::makeBox({0.16, 0.05, 0.21});
  EXPECT_GE(smallestAngle(refineEdges(box, 0.004)), 0.5 * smallestAngle(box));
}

TEST(RefineEdges, LeavesAFineMeshAsItIs) {
  const TriangleMesh plate = test::makePlate(5, 5, 0.002);
  const TriangleMesh same = refineEdges(plate, 0.004);
  EXPECT_EQ(same.vertices(), plate.vertices());
  EXPECT_EQ(same.faces(), plate.faces());
}

TEST(RefineEdges, RefusesALengthThatWouldFillMemory) {
  const TriangleMesh box = geometry::makeBox({10, 10, 10});
  EXPECT_THAT(
      [&] {
        refineEdges(box, 0.004);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("more than 2000000 vertices")));
  for (const double length : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(refineEdges(box, length), InvalidInput) << length;
}

}  // namespace
}  // namespace handgraft::contact
