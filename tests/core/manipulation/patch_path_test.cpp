#include "core/manipulation/patch_path.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/contact/edge_refinement.h"
#include "core/geometry/tangent.h"
#include "core/manipulation/grasp_interpolation.h"

namespace handgraft::manipulation {
namespace {

using contact::Patch;
using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SurfaceLocator;
using geometry::TriangleMesh;
using testing::HasSubstr;

/// An L-shaped outline about a place of the surface, as the tangent plane sees it.
Patch patchAt(const TriangleMesh& mesh, const Vector3d& p, const Vector3d& direction) {
  const SurfaceLocator locator(mesh);
  Patch patch;
  patch.name = "index";
  patch.root = locator.nearest(p).point;
  patch.direction_O = tangentAt(mesh, patch.root, direction);
  const Vector3d n = normalOf(mesh, patch.root);
  const Vector3d y = n.cross(*patch.direction_O);
  const Vector3d root = positionOf(mesh, patch.root);
  for (const Vector2d& uv :
       {Vector2d(0.008, 0.0), Vector2d(0.0, 0.004), Vector2d(-0.004, 0.004),
        Vector2d(-0.004, -0.003), Vector2d(0.008, -0.003)}) {
    patch.interpolation_boundary.push_back(
        locator.nearest(root + uv.x() * *patch.direction_O + uv.y() * y).point);
  }
  return patch;
}

const TriangleMesh& box() {
  // Fine, so that a face's inside has the face's normal.
  static const TriangleMesh mesh =
      contact::refineEdges(geometry::makeBox({0.1, 0.2, 0.1}), 0.004);
  return mesh;
}

TEST(PatchPath, IsAStraightLineOnAPlane) {
  const Patch from = patchAt(box(), {0.0, -0.05, 0.05}, Vector3d::UnitX());
  const Patch to = patchAt(box(), {0.02, 0.05, 0.05}, Vector3d::UnitX());
  const PatchPath path(box(), from, to);
  EXPECT_NEAR(path.length(), std::hypot(0.02, 0.1), 1e-9);
  for (const double share : {0.0, 0.13, 0.5, 0.99, 1.0}) {
    const Patch patch = path.at(share);
    const Vector3d shift = share * Vector3d(0.02, 0.1, 0.0);
    EXPECT_LT((positionOf(box(), patch.root) - positionOf(box(), from.root) - shift).norm(),
              1e-8)
        << share;
    EXPECT_LT((*patch.direction_O - Vector3d::UnitX()).norm(), 1e-6) << share;
    for (std::size_t i = 0; i < patch.interpolation_boundary.size(); ++i) {
      EXPECT_LT((positionOf(box(), patch.interpolation_boundary[i]) -
                 positionOf(box(), from.interpolation_boundary[i]) - shift)
                    .norm(),
                1e-6)
          << share << ", point " << i;
    }
  }
}

TEST(PatchPath, GoesOverAnEdgeByTheUnfoldedWay) {
  const Patch from = patchAt(box(), {0.0, 0.08, 0.05}, Vector3d::UnitY());
  const Patch to = patchAt(box(), {0.0, 0.1, 0.03}, -Vector3d::UnitZ());
  const PatchPath path(box(), from, to);
  EXPECT_NEAR(path.length(), 0.04, 1e-9);
  const Patch before = path.at(0.25);
  const Patch behind = path.at(0.75);
  EXPECT_LT((positionOf(box(), before.root) - Vector3d(0.0, 0.09, 0.05)).norm(), 1e-6);
  EXPECT_LT((positionOf(box(), behind.root) - Vector3d(0.0, 0.1, 0.04)).norm(), 1e-6);
  // The direction folds over the edge as the surface does.
  EXPECT_GT(before.direction_O->dot(Vector3d::UnitY()), 0.999);
  EXPECT_GT(behind.direction_O->dot(-Vector3d::UnitZ()), 0.999);
  // A point 8 mm ahead of the root is already round the edge when the root is not.
  EXPECT_LT((positionOf(box(), path.at(0.45).interpolation_boundary[0]) -
             Vector3d(0.0, 0.1, 0.05 - 0.006))
                .norm(),
            1e-4);
}

TEST(PatchPath, KeepsItsAngleToAGreatCircle) {
  constexpr double kRadius = 0.05;
  const TriangleMesh ball = geometry::makeSphere(kRadius, 5);
  const Vector3d a(kRadius, 0.0, 0.0);
  const double angle = 1.2;
  const Vector3d b = kRadius * Vector3d(std::cos(angle), std::sin(angle), 0.0);
  // Both directions half a right angle off the equator: transport leaves nothing to turn.
  const Vector3d tilt(0.0, 0.0, 1.0);
  const Patch from = patchAt(ball, a, Vector3d(0, 1, 0) + tilt);
  const Patch to = patchAt(ball, b, Vector3d(-std::sin(angle), std::cos(angle), 0.0) + tilt);
  const PatchPath path(ball, from, to);
  EXPECT_NEAR(path.length(), kRadius * angle, 2e-4);
  for (const double share : {0.2, 0.5, 0.8}) {
    const Patch patch = path.at(share);
    const double at = share * angle;
    const Vector3d expected = kRadius * Vector3d(std::cos(at), std::sin(at), 0.0);
    EXPECT_LT((positionOf(ball, patch.root) - expected).norm(), 3e-4) << share;
    const Vector3d heading(-std::sin(at), std::cos(at), 0.0);
    EXPECT_NEAR(patch.direction_O->dot(heading), std::sqrt(0.5), 0.03) << share;
    EXPECT_NEAR(patch.direction_O->z(), std::sqrt(0.5), 0.03) << share;
  }
}

TEST(PatchPath, TurnsByAndByToTheLastDirection) {
  const Patch from = patchAt(box(), {0.0, -0.05, 0.05}, Vector3d::UnitX());
  const Patch to = patchAt(box(), {0.0, 0.05, 0.05}, Vector3d::UnitY());
  const PatchPath path(box(), from, to);
  for (const double share : {0.25, 0.5, 0.75}) {
    const Vector3d direction = *path.at(share).direction_O;
    EXPECT_NEAR(std::atan2(direction.y(), direction.x()), share * std::numbers::pi / 2, 1e-4);
  }
}

TEST(PatchPath, NamesEndsThatDoNotFit) {
  const Patch from = patchAt(box(), {0.0, -0.05, 0.05}, Vector3d::UnitX());
  Patch to = from;
  to.interpolation_boundary.pop_back();
  EXPECT_THROW(PatchPath(box(), from, to), InvalidInput);
  to = from;
  to.direction_O.reset();
  EXPECT_THROW(PatchPath(box(), from, to), InvalidInput);
}

TEST(Slid, IsWhereThePathEnds) {
  const Patch from = patchAt(box(), {0.0, 0.0, 0.05}, Vector3d::UnitX());
  const Patch moved = slid(box(), from, {0.01, 0.02});
  EXPECT_LT((positionOf(box(), moved.root) - Vector3d(0.01, 0.02, 0.05)).norm(), 1e-9);
  EXPECT_LT((positionOf(box(), moved.interpolation_boundary[2]) -
             positionOf(box(), from.interpolation_boundary[2]) - Vector3d(0.01, 0.02, 0.0))
                .norm(),
            1e-6);
  EXPECT_THROW(slid(box(), from, {10.0, 0.0}), InvalidInput);
}

TEST(JoinGrasps, SlidesWhatBothHaveAndFadesTheRest) {
  contact::ContactSet first{"pull", "box", {}, {}, {}, {}};
  first.patches = {patchAt(box(), {0.0, -0.05, 0.05}, Vector3d::UnitX()),
                   patchAt(box(), {0.0, 0.0, -0.05}, Vector3d::UnitX())};
  first.patches[1].name = "thumb";
  contact::ContactSet last = first;
  last.patches[0] = slid(box(), first.patches[0], {0.0, 0.03});
  last.patches[1].name = "middle";
  Pose up = Pose::Identity();
  up.translation().z() = 0.2;
  const Motion motion =
      interpolateGrasps(box(), first, last, {{0.0, Pose::Identity()}, {2.0, up}}, {});
  ASSERT_EQ(motion.frameCount(), 121);
  ASSERT_EQ(motion.tracks.size(), 3u);
  EXPECT_EQ(motion.tracks[0].name, "index");
  EXPECT_EQ(motion.tracks[0].end, 121);
  EXPECT_EQ(motion.tracks[1].name, "thumb");
  EXPECT_EQ(motion.tracks[1].end, 48);
  EXPECT_EQ(motion.tracks[2].name, "middle");
  EXPECT_EQ(motion.tracks[2].begin(), 72);
  const auto root_at = [&](int frame) {
    return positionOf(box(), motion.tracks[0].keyAt(frame).patch.root);
  };
  EXPECT_LT((root_at(0) - Vector3d(0.0, -0.05, 0.05)).norm(), 1e-9);
  EXPECT_LT((root_at(60) - Vector3d(0.0, -0.035, 0.05)).norm(), 1e-6);
  EXPECT_LT((root_at(120) - Vector3d(0.0, -0.02, 0.05)).norm(), 1e-9);
  EXPECT_NEAR(motion.X_WO[60].translation().z(), 0.1, 1e-12);
}

TEST(JoinGrasps, NamesWhatIsWrong) {
  contact::ContactSet set{"pull", "box", {patchAt(box(), {0, 0, 0.05}, Vector3d::UnitX())},
                          {},     {},    {}};
  const std::vector<ObjectKey> back = {{1.0, Pose::Identity()}, {0.5, Pose::Identity()}};
  try {
    interpolateGrasps(box(), set, set, back);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("key 1 of the object's path: time 0.5 s"));
  }
  TwoGraspOptions options;
  options.slide_begin = 0.9;
  EXPECT_THROW(interpolateGrasps(box(), set, set, {{0.0, Pose::Identity()}}, options),
               InvalidInput);
  // One frame is a grasp.
  EXPECT_EQ(interpolateGrasps(box(), set, set, {{0.0, Pose::Identity()}}).frameCount(), 1);
}

}  // namespace
}  // namespace handgraft::manipulation
