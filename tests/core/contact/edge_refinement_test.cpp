#include "core/contact/edge_refinement.h"

#include <algorithm>
#include <limits>
#include <vector>

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

TEST(RefineEdges, NamesTheFaceThatEachOneLiesIn) {
  const TriangleMesh box = geometry::makeBox({0.03, 0.02, 0.05});
  std::vector<int> parents;
  const TriangleMesh fine = refineEdges(box, 0.004, &parents);
  ASSERT_EQ(parents.size(), static_cast<std::size_t>(fine.faceCount()));
  std::vector<double> areas(static_cast<std::size_t>(box.faceCount()), 0.0);
  const auto area_of = [](const TriangleMesh& mesh, int f) {
    const Eigen::Vector3i face = mesh.face(f);
    return 0.5 * (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                     .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                     .norm();
  };
  for (int f = 0; f < fine.faceCount(); ++f) {
    const auto parent = static_cast<std::size_t>(parents[static_cast<std::size_t>(f)]);
    areas[parent] += area_of(fine, f);
    EXPECT_TRUE(fine.faceNormals().col(f).isApprox(
        box.faceNormals().col(static_cast<Eigen::Index>(parent)), 1e-9));
  }
  for (int f = 0; f < box.faceCount(); ++f)
    EXPECT_NEAR(areas[static_cast<std::size_t>(f)], area_of(box, f), 1e-12);
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
