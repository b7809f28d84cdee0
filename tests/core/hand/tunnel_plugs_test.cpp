#include "core/hand/tunnel_plugs.h"

#include <gtest/gtest.h>

#include "core/hand/skin_wrap.h"
#include "core/hand/voxel_solid.h"

namespace handgraft::hand {
namespace {

geometry::TriangleMesh boxAt(const Eigen::Vector3d& size, const Eigen::Vector3d& centre) {
  Eigen::Affine3d X = Eigen::Affine3d::Identity();
  X.translation() = centre;
  return geometry::transformed(geometry::makeBox(size), X);
}

/// A plate of 80 x 40 x 8 mm with two square holes of 20 mm, as bars that overlap.
geometry::TriangleMesh makeFrame() {
  return geometry::merged({boxAt({0.08, 0.01, 0.008}, {0.0, 0.015, 0.0}),
                           boxAt({0.08, 0.01, 0.008}, {0.0, -0.015, 0.0}),
                           boxAt({0.01, 0.04, 0.008}, {0.035, 0.0, 0.0}),
                           boxAt({0.02, 0.04, 0.008}, {0.0, 0.0, 0.0}),
                           boxAt({0.01, 0.04, 0.008}, {-0.035, 0.0, 0.0})});
}

/// V - E + F - C of the voxels' cubes, counted with all their sides: 1 for a ball, 0 for a
/// ring.
int eulerCharacteristicOf(const VoxelSet& solid, const VoxelGrid& grid) {
  // Cells of the cubical complex lie at half steps: one with k odd coordinates has dimension k.
  const Eigen::Vector3i n = 2 * grid.size + Eigen::Vector3i::Ones();
  std::vector<char> is_there(static_cast<std::size_t>(n.prod()), 0);
  for (std::size_t i = 0; i < solid.size(); ++i) {
    if (solid[i] == 0) continue;
    const Eigen::Vector3i c = 2 * grid.cell(i);
    for (int k = 0; k < 27; ++k)
      is_there[static_cast<std::size_t>(((c.z() + k / 9) * n.y() + c.y() + k / 3 % 3) * n.x() +
                                        c.x() + k % 3)] = 1;
  }
  int sum = 0;
  for (int i = 0; i < n.prod(); ++i) {
    if (is_there[static_cast<std::size_t>(i)] == 0) continue;
    const int odd = i % n.x() % 2 + i / n.x() % n.y() % 2 + i / n.x() / n.y() % 2;
    sum += odd % 2 == 0 ? 1 : -1;
  }
  return sum;
}

TEST(VoxelSolid, HoldsTheVolumeOfABall) {
  const geometry::TriangleMesh ball = geometry::makeSphere(0.02, 4);
  const VoxelGrid grid = gridAround(ball, 0.001, 1'000'000);
  const VoxelSet inside = voxelsInside(ball, grid);
  double volume_mm3 = 0.0;
  for (const auto voxel : inside)
    volume_mm3 += voxel;
  EXPECT_NEAR(volume_mm3, 4.0 / 3.0 * 3.14159265 * 8000.0, 350.0);
}

TEST(VoxelSolid, KeepsToTheVoxelsAllowed) {
  const VoxelGrid grid = gridAround(geometry::makeSphere(0.5, 3), 1e-4, 100'000);
  EXPECT_LE(grid.count(), 100'000u);
  EXPECT_GT(grid.count(), 50'000u);
}

TEST(ShrinkWrapped, LeavesABallAsItIs) {
  const geometry::TriangleMesh ball = geometry::makeSphere(0.02, 3);
  const VoxelGrid grid = gridAround(ball, 0.002, 1'000'000);
  const VoxelSet inside = voxelsInside(ball, grid);
  EXPECT_EQ(shrinkWrapped(inside, grid), inside);
}

TEST(ShrinkWrapped, MakesABallOfAFrame) {
  const geometry::TriangleMesh frame = wrapped(makeFrame(), 0.003, 0.0008, Progress());
  const VoxelGrid grid = gridAround(frame, 0.0015, 1'000'000);
  const VoxelSet inside = voxelsInside(frame, grid);
  ASSERT_EQ(eulerCharacteristicOf(inside, grid), -1);
  const VoxelSet shut = shrinkWrapped(inside, grid);
  EXPECT_EQ(eulerCharacteristicOf(shut, grid), 1);
  for (std::size_t i = 0; i < inside.size(); ++i)
    ASSERT_LE(inside[i], shut[i]);
}

TEST(VoxelsOutOfReach, AreABoxAndWhatNoBallGetsInto) {
  // Two plates 4 mm apart, without their rims: a ball of 3 mm stays out, one of 1.5 goes in.
  const geometry::TriangleMesh plates =
      geometry::merged({boxAt({0.04, 0.04, 0.002}, {0.0, 0.0, 0.003}),
                        boxAt({0.04, 0.04, 0.002}, {0.0, 0.0, -0.003})});
  const VoxelGrid grid = gridAround(plates, 0.0005, 4'000'000, 0.003);
  const auto is_solid = [&](double ball_radius_m, const Eigen::Vector3d& p) {
    const Eigen::Vector3i c = ((p - grid.origin_S) / grid.step_m).array().round().cast<int>();
    return voxelsOutOfReach(plates, grid, ball_radius_m)[grid.index(c.x(), c.y(), c.z())] != 0;
  };
  EXPECT_TRUE(is_solid(0.003, {0.0, 0.0, 0.003}));
  EXPECT_TRUE(is_solid(0.003, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(is_solid(0.003, {0.0, 0.0, 0.0055}));
  EXPECT_TRUE(is_solid(0.0015, {0.0, 0.0, 0.003}));
  EXPECT_FALSE(is_solid(0.0015, {0.0, 0.0, 0.0}));
}

TEST(LargestPiece, LeavesOutTheOthers) {
  const geometry::TriangleMesh boxes =
      geometry::merged({boxAt({0.02, 0.01, 0.01}, {0.0, 0.0, 0.0}),
                        boxAt({0.01, 0.01, 0.01}, {0.05, 0.0, 0.0})});
  const VoxelGrid grid = gridAround(boxes, 0.001, 1'000'000);
  const VoxelSet both = voxelsInside(boxes, grid);
  const auto [one, share] = largestPiece(both, grid);
  EXPECT_NEAR(share, 2.0 / 3.0, 0.05);
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_EQ(one[i], grid.middle(i).x() < 0.03 ? both[i] : 0);
  EXPECT_EQ(largestPiece(VoxelSet(grid.count(), 0), grid).second, 0.0);
}

TEST(Wrapping, GoesOnAudiblyAndStopsInTheMidst) {
  int reports = 0;
  Progress* running = nullptr;
  Progress progress([&](std::string_view, double share) {
    EXPECT_GT(share, 0.0);
    EXPECT_LT(share, 1.0);
    if (++reports == 3) running->cancel();
  });
  running = &progress;
  EXPECT_THROW((void)wrapped(geometry::makeSphere(0.05, 3), 0.001, 0.0005, progress),
               Cancelled);
  EXPECT_EQ(reports, 3);
}

TEST(TunnelPlugs, SpanEachHoleOnce) {
  const geometry::TriangleMesh frame = wrapped(makeFrame(), 0.003, 0.0008, Progress());
  ASSERT_EQ(frame.eulerCharacteristic(), -2);
  const TunnelPlugs plugs = findTunnelPlugs(frame, 0.0015);
  EXPECT_EQ(plugs.count, 2);
  // Each hole is 20 mm less the wrap's offset on either side.
  EXPECT_NEAR(plugs.area_m2, 2.0 * 0.0184 * 0.0184, 0.2 * 2.0 * 0.0184 * 0.0184);
  // The narrowest place of a straight hole is anywhere along it, but within the plate.
  EXPECT_LT(plugs.sheets_S.vertices().row(2).cwiseAbs().maxCoeff(), 0.0048);
  const geometry::TriangleMesh shut =
      wrapped(geometry::merged({makeFrame(), plugs.sheets_S}), 0.003, 0.0008, Progress());
  EXPECT_EQ(shut.eulerCharacteristic(), 2);
}

TEST(TunnelPlugs, AreFoundAheadOfTheWrap) {
  const TunnelPlugs plugs = findTunnelPlugsOfWrap(makeFrame(), 0.003, 0.0008, 0.0015);
  EXPECT_EQ(plugs.count, 2);
  EXPECT_NEAR(plugs.area_m2, 2.0 * 0.02 * 0.02, 0.3 * 2.0 * 0.02 * 0.02);
  EXPECT_LT(plugs.sheets_S.vertices().row(2).cwiseAbs().maxCoeff(), 0.0048);
  const geometry::TriangleMesh shut =
      wrapped(geometry::merged({makeFrame(), plugs.sheets_S}), 0.003, 0.0008, Progress());
  EXPECT_EQ(shut.eulerCharacteristic(), 2);
}

TEST(TunnelPlugs, JoinNoPiecesAheadOfTheWrap) {
  // A frame and a box beside it: what shuts the frame's holes would also reach for the box.
  const geometry::TriangleMesh apart =
      geometry::merged({makeFrame(), boxAt({0.03, 0.03, 0.03}, {0.2, 0.0, 0.0})});
  EXPECT_EQ(findTunnelPlugsOfWrap(apart, 0.003, 0.0008, 0.0015).count, 0);
}

TEST(TunnelPlugs, AreNoneForABall) {
  const TunnelPlugs plugs = findTunnelPlugs(geometry::makeSphere(0.03, 3), 0.0015);
  EXPECT_EQ(plugs.count, 0);
  EXPECT_EQ(plugs.sheets_S.faceCount(), 0);
}

TEST(SelfIntersections, AreFoundWhereABoxPiercesAnother) {
  const auto apart =
      geometry::merged({boxAt({1, 1, 1}, {0.0, 0.0, 0.0}), boxAt({1, 1, 1}, {1.5, 0.0, 0.0})});
  EXPECT_TRUE(selfIntersectingFaces(apart).empty());
  const auto piercing = geometry::merged(
      {boxAt({1, 1, 1}, {0.0, 0.0, 0.0}), boxAt({1, 0.5, 0.5}, {0.7, 0.0, 0.0})});
  EXPECT_FALSE(selfIntersectingFaces(piercing).empty());
}

}  // namespace
}  // namespace handgraft::hand
