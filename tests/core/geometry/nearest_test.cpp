#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/kd_tree.h"
#include "core/geometry/surface_locator.h"

namespace handgraft::geometry {
namespace {

Eigen::Vector3d randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
  const double x = coordinate(random);
  const double y = coordinate(random);
  return {x, y, coordinate(random)};
}

TEST(KdTree, AgreesWithASearchThroughAll) {
  std::mt19937 random(1);
  Eigen::Matrix3Xd points(3, 500);
  for (int i = 0; i < 500; ++i)
    points.col(i) = randomPoint(random);
  const KdTree tree(points);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p = randomPoint(random);
    int nearest = 0;
    const double distance =
        std::sqrt((points.colwise() - p).colwise().squaredNorm().minCoeff(&nearest));
    const KdTree::Hit hit = tree.nearest(p);
    EXPECT_EQ(hit.index, nearest);
    EXPECT_NEAR(hit.distance, distance, 1e-12);
  }
}

TEST(KdTree, GivesTiesToTheLowestIndex) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 60);
  points.row(0).head(30).setConstant(-1.0);
  points.row(0).tail(30).setConstant(1.0);
  EXPECT_EQ(KdTree(points).nearest(Eigen::Vector3d::Zero()).index, 0);
  EXPECT_EQ(KdTree(points).nearest({0.5, 0.0, 0.0}).index, 30);
}

TEST(KdTree, ListsTheNearestFewInOrder) {
  std::mt19937 random(2);
  Eigen::Matrix3Xd points(3, 300);
  for (int i = 0; i < 300; ++i)
    points.col(i) = randomPoint(random);
  points.col(200) = points.col(100);  // equals: the lower index first
  const KdTree tree(points);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = i == 0 ? Eigen::Vector3d(points.col(100)) : randomPoint(random);
    std::vector<std::pair<double, int>> all;
    for (int k = 0; k < 300; ++k)
      all.emplace_back((points.col(k) - p).squaredNorm(), k);
    std::sort(all.begin(), all.end());
    const auto few = tree.nearestFew(p, 9);
    ASSERT_EQ(few.size(), 9u);
    for (std::size_t k = 0; k < 9; ++k)
      EXPECT_EQ(few[k].index, all[k].second);
  }
  EXPECT_EQ(tree.nearestFew(Eigen::Vector3d::Zero(), 500).size(), 300u);
}

TEST(KdTree, ListsAllWithinARadius) {
  Eigen::Matrix3Xd points(3, 5);
  points.row(0) << 3, 1, 2, -1, 0;  // along a line, whose distances are exact
  points.bottomRows(2).setZero();
  const KdTree tree(points);
  const auto indices = [&](double radius) {
    std::vector<int> found;
    for (const KdTree::Hit& hit : tree.within(Eigen::Vector3d::Zero(), radius))
      found.push_back(hit.index);
    return found;
  };
  EXPECT_EQ(indices(2.0), (std::vector<int>{4, 1, 3, 2}));
  EXPECT_EQ(indices(1.5), (std::vector<int>{4, 1, 3}));
  EXPECT_EQ(indices(0.0), (std::vector<int>{4}));
  EXPECT_TRUE(tree.within({9, 9, 9}, 1.0).empty());
}

TEST(KdTree, RefusesWhatIsNotFinite) {
  EXPECT_THROW(KdTree(Eigen::Matrix3Xd(3, 0)), InvalidInput);
  EXPECT_THROW(KdTree(Eigen::Matrix3Xd::Constant(3, 1, std::nan(""))), InvalidInput);
  const KdTree one(Eigen::Matrix3Xd::Zero(3, 1));
  EXPECT_THROW(static_cast<void>(one.nearest({std::nan(""), 0, 0})), InvalidInput);
  EXPECT_THROW(static_cast<void>(one.within({std::nan(""), 0, 0}, 1.0)), InvalidInput);
}

TEST(SurfaceLocator, FindsTheNearestPlaceOfABox) {
  const SurfaceLocator locator(makeBox({2.0, 2.0, 2.0}));
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = randomPoint(random);
    const SurfaceLocator::Hit hit = locator.nearest(p);
    Eigen::Vector3d truth = p.cwiseMax(-1.0).cwiseMin(1.0);
    if (truth == p) {
      int axis = 0;
      p.cwiseAbs().maxCoeff(&axis);
      truth[axis] = p[axis] < 0.0 ? -1.0 : 1.0;
    }
    EXPECT_LT((hit.position - truth).norm(), 1e-12);
    EXPECT_LT((positionOf(locator.mesh(), hit.point) - truth).norm(), 1e-12);
    EXPECT_NEAR(hit.distance, (p - truth).norm(), 1e-12);
    validate(locator.mesh(), hit.point, "hit");
  }
}

TEST(SurfaceLocator, TakesFacesWithoutAreaAsSegments) {
  Eigen::Matrix3Xd vertices(3, 3);
  vertices << 0, 1, 2, 0, 0, 0, 0, 0, 0;
  const SurfaceLocator locator(TriangleMesh(vertices, Eigen::Vector3i(0, 1, 2)));
  const SurfaceLocator::Hit hit = locator.nearest({1.5, 1.0, 0.0});
  EXPECT_EQ(hit.position, Eigen::Vector3d(1.5, 0.0, 0.0));
  EXPECT_DOUBLE_EQ(hit.distance, 1.0);
}

TEST(SurfaceLocator, FindsNothingBeyondItsReach) {
  const SurfaceLocator locator(makeSphere(1.0, 3));
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = randomPoint(random);
    const SurfaceLocator::Hit hit = locator.nearest(p);
    EXPECT_FALSE(locator.nearest(p, 0.999 * hit.distance));
    const auto within = locator.nearest(p, 1.001 * hit.distance);
    ASSERT_TRUE(within);
    EXPECT_EQ(within->point.face, hit.point.face);
    EXPECT_EQ(within->position, hit.position);
  }
  const SurfaceLocator box(makeBox({2, 2, 2}));
  EXPECT_TRUE(box.nearest({0.0, 0.0, 3.0}, 2.0));
  EXPECT_FALSE(box.nearest({0.0, 0.0, 3.0}, std::nan("")));
  EXPECT_THROW(static_cast<void>(box.nearest({0, std::nan(""), 0}, 1.0)), InvalidInput);
}

TEST(SurfaceLocator, ListsTheFacesThatABoxMayTouch) {
  const TriangleMesh ball = makeSphere(1.0, 3);
  const SurfaceLocator locator(ball);
  std::mt19937 random(4);
  std::vector<int> faces;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = randomPoint(random);
    Eigen::AlignedBox3d box(a);
    box.extend(Eigen::Vector3d(a + 0.2 * randomPoint(random)));
    std::vector<int> expected;
    for (int f = 0; f < ball.faceCount(); ++f) {
      Eigen::AlignedBox3d face;
      for (int c = 0; c < 3; ++c)
        face.extend(ball.vertex(ball.face(f)[c]));
      if (face.intersects(box)) expected.push_back(f);
    }
    locator.facesTouching(box, faces);
    std::sort(faces.begin(), faces.end());
    EXPECT_EQ(faces, expected);
  }
}

TEST(SurfaceLocator, RefusesAnEmptyMeshAndPointsThatAreNotFinite) {
  EXPECT_THROW(SurfaceLocator{TriangleMesh()}, InvalidInput);
  const SurfaceLocator box(makeBox({1, 1, 1}));
  EXPECT_THROW(static_cast<void>(box.nearest({0, std::nan(""), 0})), InvalidInput);
}

}  // namespace
}  // namespace handgraft::geometry
