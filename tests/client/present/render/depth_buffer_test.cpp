#include "client/present/render/depth_buffer.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace handgraft::client::render {
namespace {

int countOf(const DepthBuffer& buffer, std::uint32_t id) {
  int count = 0;
  for (int y = 0; y < buffer.height(); ++y) {
    for (int x = 0; x < buffer.width(); ++x)
      count += buffer.idAt(x, y) == id ? 1 : 0;
  }
  return count;
}

TEST(DepthBuffer, CoversTheSamplesInsideATriangle) {
  DepthBuffer buffer(8, 8);
  buffer.drawTriangle({{{1, 1, 1}, {7, 1, 1}, {1, 7, 1}}}, 5);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const double sx = x + 0.5;
      const double sy = y + 0.5;
      const bool strictly_inside = sx > 1 && sy > 1 && sx + sy < 8;
      const bool on_edge =
          sx + sy == 8;  // the slanted edge is right, not left: it owns nothing
      EXPECT_EQ(buffer.idAt(x, y) == 5, strictly_inside && !on_edge) << x << ' ' << y;
    }
  }
}

TEST(DepthBuffer, CoversTheSameSamplesForBothOrientations) {
  DepthBuffer one(32, 32);
  DepthBuffer other(32, 32);
  one.drawTriangle({{{2.3F, 4.1F, 1}, {29.7F, 9.2F, 1}, {11.0F, 30.5F, 1}}}, 0);
  other.drawTriangle({{{2.3F, 4.1F, 1}, {11.0F, 30.5F, 1}, {29.7F, 9.2F, 1}}}, 0);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x)
      EXPECT_EQ(one.idAt(x, y), other.idAt(x, y));
  }
}

TEST(DepthBuffer, GivesEverySampleOfAFanToExactlyOneTriangle) {
  // Vertices on a coarse grid of half samples put many samples exactly on shared edges.
  std::mt19937 generator(7);
  std::uniform_int_distribution<int> grid(8, 24);
  for (int round = 0; round < 200; ++round) {
    const ScreenPoint center{0.5F * static_cast<float>(grid(generator)) + 8.0F,
                             0.5F * static_cast<float>(grid(generator)) + 8.0F, 1.0F};
    const std::array<ScreenPoint, 4> rim = {{{0, 0, 1}, {32, 0, 1}, {32, 32, 1}, {0, 32, 1}}};
    int covered = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      DepthBuffer buffer(32, 32);
      buffer.drawTriangle({center, rim[k], rim[(k + 1) % 4]}, 0);
      covered += countOf(buffer, 0);
    }
    ASSERT_EQ(covered, 32 * 32) << "center " << center.x << ' ' << center.y;
  }
}

TEST(DepthBuffer, KeepsTheNearerSurfaceWhateverComesFirst) {
  const std::array<ScreenPoint, 3> far = {{{0, 0, 1}, {16, 0, 1}, {0, 16, 1}}};
  const std::array<ScreenPoint, 3> near = {{{0, 0, 2}, {16, 0, 2}, {0, 16, 2}}};
  DepthBuffer buffer(16, 16);
  buffer.drawTriangle(near, 1);
  buffer.drawTriangle(far, 2);
  EXPECT_EQ(buffer.idAt(3, 3), 1U);
  DepthBuffer reversed(16, 16);
  reversed.drawTriangle(far, 2);
  reversed.drawTriangle(near, 1);
  EXPECT_EQ(reversed.idAt(3, 3), 1U);
}

TEST(DepthBuffer, CutsCrossingTrianglesAlongTheirCommonLine) {
  DepthBuffer buffer(64, 64);
  buffer.drawTriangle({{{0, 0, 0}, {128, 0, 128}, {0, 128, 0}}}, 1);   // nearness = x
  buffer.drawTriangle({{{0, 0, 20}, {128, 0, 20}, {0, 128, 20}}}, 2);  // nearness = 20
  for (int x = 0; x < 64; ++x) {
    EXPECT_EQ(buffer.idAt(x, 10), x + 0.5 > 20 ? 1U : 2U) << x;
    EXPECT_NEAR(buffer.nearnessAt(x, 10), std::max(x + 0.5, 20.0), 1e-4);
  }
}

TEST(DepthBuffer, LeavesAnythingThatIsNoNumberAlone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  DepthBuffer buffer(16, 16);
  for (const float bad : {nan, inf, -inf, 1e30F}) {
    buffer.drawTriangle({{{bad, 0, 1}, {16, 0, 1}, {0, 16, 1}}}, 1);
    buffer.drawTriangle({{{0, 0, 1}, {16, bad, 1}, {0, 16, 1}}}, 1);
    buffer.drawSegment({bad, 0, 1}, {8, 8, 1}, 2.0F, 1);
    buffer.drawSegment({0, 0, 1}, {8, 8, 1}, std::isnan(bad) ? bad : -1.0F, 1);
  }
  buffer.drawTriangle({{{0, 0, nan}, {16, 0, 1}, {0, 16, 1}}}, 1);
  EXPECT_EQ(countOf(buffer, 1), 0);
}

TEST(DepthBuffer, CutsOffWhatLeavesThePicture) {
  DepthBuffer buffer(16, 16);
  buffer.drawTriangle({{{-1000, -1000, 1}, {3000, -1000, 1}, {-1000, 3000, 1}}}, 1);
  EXPECT_EQ(countOf(buffer, 1), 256);
  buffer.drawSegment({-500, 8, 2}, {500, 8, 2}, 2.0F, 3);
  EXPECT_EQ(countOf(buffer, 3), 32);
  buffer.drawTriangle({{{100, 100, 9}, {200, 100, 9}, {100, 200, 9}}}, 4);
  EXPECT_EQ(countOf(buffer, 4), 0);
}

TEST(DepthBuffer, DrawsDiscsOfTheRightSize) {
  DepthBuffer buffer(200, 200);
  buffer.drawSegment({100, 100, 1}, {100, 100, 1}, 100.0F, 1);
  EXPECT_NEAR(countOf(buffer, 1), 3.14159265 * 2500.0, 60.0);  // pi r^2, give or take the rim
}

}  // namespace
}  // namespace handgraft::client::render
