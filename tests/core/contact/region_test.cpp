#include "core/contact/region.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

/// Both faces of each of the plate's cells that `inside(i, j)` accepts.
template <class Inside>
std::vector<char> markCells(int columns, int rows, const Inside& inside) {
  std::vector<char> marked;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i)
      marked.insert(marked.end(), 2, inside(i, j) ? 1 : 0);
  }
  return marked;
}

/// Twice the area that a loop in the xy plane encloses, positive if counter-clockwise.
double signedArea(const TriangleMesh& mesh, const std::vector<int>& loop) {
  double sum = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector3d a = mesh.vertex(loop[i]);
    const Eigen::Vector3d b = mesh.vertex(loop[(i + 1) % loop.size()]);
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

TEST(ConnectedRegions, AreJoinedByEdgesNotByVertices) {
  const TriangleMesh mesh = test::makePlate(4, 4, 1.0);
  const auto marked = markCells(4, 4, [](int i, int j) {
    return (i < 2) == (j < 2);
  });
  const std::vector<Region> regions = connectedRegions(mesh, marked);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[0].size(), 8u);
  EXPECT_EQ(regions[1].size(), 8u);
}

TEST(OuterBoundary, RunsCounterClockwiseAroundASquare) {
  const TriangleMesh mesh = test::makePlate(6, 6, 1.0);
  const auto regions = connectedRegions(mesh, markCells(6, 6, [](int i, int j) {
                                          return i > 0 && i < 5 && j > 1 && j < 5;
                                        }));
  const OuterBoundary boundary = outerBoundary(mesh, regions.at(0));
  EXPECT_EQ(boundary.loop.size(), 14u);
  EXPECT_EQ(boundary.other_loops, 0);
  EXPECT_DOUBLE_EQ(signedArea(mesh, boundary.loop), 12.0);
}

TEST(OuterBoundary, LeavesHolesOut) {
  const TriangleMesh mesh = test::makePlate(7, 7, 1.0);
  const auto regions = connectedRegions(mesh, markCells(7, 7, [](int i, int j) {
                                          return i != 3 || j != 3;
                                        }));
  const OuterBoundary boundary = outerBoundary(mesh, regions.at(0));
  EXPECT_DOUBLE_EQ(signedArea(mesh, boundary.loop), 49.0);
  EXPECT_EQ(boundary.other_loops, 1);
}

TEST(OuterBoundary, IsSimpleWhereItPinchesItself) {
  // A ring of cells whose hole touches the outside in one vertex: cells (2,2) and (3,3)
  // missing.
  const TriangleMesh mesh = test::makePlate(4, 4, 1.0);
  const auto regions = connectedRegions(mesh, markCells(4, 4, [](int i, int j) {
                                          return !(i == 2 && j == 2) && !(i == 3 && j == 3);
                                        }));
  ASSERT_EQ(regions.size(), 1u);
  const OuterBoundary boundary = outerBoundary(mesh, regions[0]);
  const std::set<int> once(boundary.loop.begin(), boundary.loop.end());
  EXPECT_EQ(once.size(), boundary.loop.size());
  EXPECT_EQ(boundary.other_loops, 1);
  EXPECT_DOUBLE_EQ(signedArea(mesh, boundary.loop), 15.0);  // all but the outer missing cell
}

TEST(OuterBoundary, IsMissingOnAClosedSurface) {
  const TriangleMesh mesh = geometry::makeSphere(1.0, 1);
  const auto regions = connectedRegions(mesh, std::vector<char>(mesh.faceCount(), 1));
  EXPECT_TRUE(outerBoundary(mesh, regions.at(0)).loop.empty());
}

TEST(GeodesicCentre, IsTheMiddleOfASquare) {
  const TriangleMesh mesh = test::makePlate(10, 10, 1.0);
  const auto regions = connectedRegions(mesh, markCells(10, 10, [](int i, int j) {
                                          return i >= 2 && i < 8 && j >= 2 && j < 8;
                                        }));
  const OuterBoundary boundary = outerBoundary(mesh, regions.at(0));
  const int centre = geodesicCentre(mesh, regions.at(0), boundary.loop);
  EXPECT_LE(mesh.vertex(centre).cwiseAbs().maxCoeff(), 1.0) << mesh.vertex(centre).transpose();
}

TEST(GeodesicCentre, LiesInsideAUShapeNotInItsHollow) {
  const TriangleMesh mesh = test::makePlate(12, 12, 1.0);
  const auto in_shape = [](int i, int j) {
    return j < 3 || i < 3 || i >= 9;
  };
  const auto regions = connectedRegions(mesh, markCells(12, 12, in_shape));
  const OuterBoundary boundary = outerBoundary(mesh, regions.at(0));
  const int centre = geodesicCentre(mesh, regions.at(0), boundary.loop);
  // By paths inside the U, its middle is the middle of the lower bar.
  EXPECT_LE(std::abs(mesh.vertex(centre).x()), 1.0);
  EXPECT_LT(mesh.vertex(centre).y(), -3.0);
  EXPECT_EQ(std::count(boundary.loop.begin(), boundary.loop.end(), centre), 0);
}

}  // namespace
}  // namespace handgraft::contact
