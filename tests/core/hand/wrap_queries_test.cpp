#include "core/hand/wrap_queries.h"

#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::hand {
namespace {

using Tetrahedron = std::array<Eigen::Vector3d, 4>;
using Triangle = std::array<Eigen::Vector3d, 3>;

const Tetrahedron unit_corner{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0),
                              Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)};

Eigen::Vector3d randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const double x = coordinate(random);
  const double y = coordinate(random);
  return {x, y, coordinate(random)};
}

/// How deep the two lie in each other along the best of all axes that could part them;
/// negative where one does. Separating axes, of unit length.
double overlapOf(const Tetrahedron& tetrahedron, const Triangle& triangle) {
  std::vector<Eigen::Vector3d> axes{
      (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0])};
  for (std::size_t i = 0; i < 4; ++i)
    axes.push_back((tetrahedron[(i + 1) % 4] - tetrahedron[i])
                       .cross(tetrahedron[(i + 2) % 4] - tetrahedron[i]));
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < i; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        axes.push_back(
            (tetrahedron[i] - tetrahedron[k]).cross(triangle[c] - triangle[(c + 1) % 3]));
  double overlap = 1e9;
  for (const Eigen::Vector3d& axis : axes) {
    Eigen::Vector2d t(1e9, -1e9);
    Eigen::Vector2d s(1e9, -1e9);
    for (const auto& p : tetrahedron)
      t = {std::min(t[0], axis.normalized().dot(p)), std::max(t[1], axis.normalized().dot(p))};
    for (const auto& p : triangle)
      s = {std::min(s[0], axis.normalized().dot(p)), std::max(s[1], axis.normalized().dot(p))};
    overlap = std::min({overlap, t[1] - s[0], s[1] - t[0]});
  }
  return overlap;
}

TEST(TouchOf, AgreesWithSeparatingAxes) {
  std::mt19937 random(4);
  int touching = 0;
  int apart = 0;
  for (int i = 0; i < 20000; ++i) {
    const Tetrahedron tetrahedron{randomPoint(random), randomPoint(random), randomPoint(random),
                                  randomPoint(random)};
    // Large, small and long ones.
    const double size = std::pow(10.0, -2.0 * (i % 3));
    const Eigen::Vector3d at = randomPoint(random);
    const Triangle triangle{at + size * randomPoint(random), at + size * randomPoint(random),
                            at + randomPoint(random)};
    const double overlap = overlapOf(tetrahedron, triangle);
    if (std::abs(overlap) < 1e-4) continue;
    const Touch touch = touchOf(tetrahedron, triangle);
    if (touch == Touch::kTooCloseToTell) continue;
    EXPECT_EQ(touch == Touch::kYes, overlap > 0.0) << "overlap " << overlap;
    ++(overlap > 0.0 ? touching : apart);
  }
  EXPECT_GT(touching, 2000);
  EXPECT_GT(apart, 9000);
}

TEST(TouchOf, DoesNotDecideWhatRoundingMight) {
  // On a side, with a corner in one, along an edge: whatever it is, it is not clear.
  for (const Triangle& triangle :
       {Triangle{Eigen::Vector3d(0.1, 0.1, 0), Eigen::Vector3d(0.2, 0.1, 0),
                 Eigen::Vector3d(0.1, 0.2, 0)},
        Triangle{Eigen::Vector3d(0.1, 0.1, 0), Eigen::Vector3d(0.2, 0.1, -1),
                 Eigen::Vector3d(0.1, 0.2, -1)},
        Triangle{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, 1),
                 Eigen::Vector3d(-1, 0, 0)}})
    EXPECT_EQ(touchOf(unit_corner, triangle), Touch::kTooCloseToTell);
}

TEST(TouchOf, SeesATriangleWithin) {
  const Triangle within{Eigen::Vector3d(0.1, 0.1, 0.1), Eigen::Vector3d(0.2, 0.1, 0.1),
                        Eigen::Vector3d(0.1, 0.2, 0.1)};
  const Triangle across{Eigen::Vector3d(-9, -9, 0.2), Eigen::Vector3d(9, -9, 0.2),
                        Eigen::Vector3d(0, 9, 0.2)};
  EXPECT_EQ(touchOf(unit_corner, within), Touch::kYes);
  EXPECT_EQ(touchOf(unit_corner, across), Touch::kYes);
}

TEST(WrapQueries, FindsTheNearestWhereverItWasAskedBefore) {
  const geometry::TriangleMesh ball = geometry::makeSphere(0.5, 3);
  const WrapQueries queries(ball);
  const geometry::SurfaceLocator locator(ball);
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p = randomPoint(random);
    const auto expected = locator.nearest(p);
    const auto& found = queries.nearest(p);
    EXPECT_EQ(found.distance, expected.distance);
    EXPECT_EQ(found.position, expected.position);
    EXPECT_EQ(queries.nearest(p).point.face, expected.point.face);
  }
}

TEST(WrapQueries, StopsWhereTheOffsetBegins) {
  const WrapQueries box(geometry::makeBox({2.0, 2.0, 2.0}));
  const double offset = 0.1;
  const auto straight = box.firstWithin(offset, {0.3, 0.2, 3.0}, {0.3, 0.2, 0.0});
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->z(), 1.1, 0.01 * offset);
  EXPECT_NEAR(straight->x(), 0.3, 1e-12);
  // Towards an edge, slanting.
  const auto slanting = box.firstWithin(offset, {3.0, 0.0, 2.0}, {0.0, 0.0, 0.5});
  ASSERT_TRUE(slanting);
  EXPECT_NEAR(box.nearest(*slanting).distance, offset, 0.01 * offset);
  // Past it, just too far away; and too short.
  EXPECT_FALSE(box.firstWithin(offset, {-3.0, 0.0, 1.102}, {3.0, 0.0, 1.102}));
  EXPECT_TRUE(box.firstWithin(offset, {-3.0, 0.0, 1.098}, {3.0, 0.0, 1.098}));
  EXPECT_FALSE(box.firstWithin(offset, {0.0, 0.0, 3.0}, {0.0, 0.0, 1.2}));
}

/// A cell that the tree passes over, or that the last place settles, is answered as one that is
/// looked at triangle by triangle.
TEST(WrapQueries, SeesTheSameTrianglesAsALookAtAll) {
  const geometry::TriangleMesh ball = geometry::makeSphere(0.5, 3);
  const WrapQueries queries(ball);
  std::mt19937 random(6);
  std::vector<int> unclear;
  int touching = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d at = randomPoint(random);
    Tetrahedron cell;
    for (Eigen::Vector3d& corner : cell)
      corner = at + 0.2 * randomPoint(random);
    bool expected = false;
    bool is_clear = true;
    for (int f = 0; f < ball.faceCount(); ++f) {
      const Touch touch =
          touchOf(cell, {ball.vertex(ball.face(f)[0]), ball.vertex(ball.face(f)[1]),
                         ball.vertex(ball.face(f)[2])});
      expected = expected || touch == Touch::kYes;
      is_clear = is_clear && touch != Touch::kTooCloseToTell;
    }
    if (i % 2 == 0) (void)queries.nearest(at);
    const Touch touch = queries.touches(cell, unclear);
    if (touch == Touch::kTooCloseToTell) {
      EXPECT_FALSE(unclear.empty());
      EXPECT_FALSE(is_clear);
      continue;
    }
    EXPECT_EQ(touch == Touch::kYes, expected);
    touching += expected ? 1 : 0;
  }
  EXPECT_GT(touching, 200);
}

TEST(WrapQueries, NeedATriangle) {
  EXPECT_THROW(WrapQueries{geometry::TriangleMesh()}, InvalidInput);
}

}  // namespace
}  // namespace handgraft::hand
