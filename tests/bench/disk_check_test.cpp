// What `handgraft-bench survey` counts must be nothing, here on meshes whole and broken.
#include "tests/bench/disk_check.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::bench {
namespace {

using geometry::LogMapMethod;
using geometry::TriangleMesh;

constexpr LogMapMethod kMethods[] = {LogMapMethod::kFast, LogMapMethod::kExact,
                                     LogMapMethod::kAuto, LogMapMethod::kSmooth};

DiskTally survey(const TriangleMesh& mesh, int roots) {
  DiskTally sum;
  for (const Damage damage : kDamages) {
    const TriangleMesh damaged = broken(mesh, damage, 3);
    const auto maps = geometry::LogMapper::borrowing(damaged);
    for (const Root& root : randomRoots(damaged, roots, 7)) {
      for (const LogMapMethod method : kMethods)
        sum += checkDisk(*maps, root.point, root.radius, method);
    }
  }
  return sum;
}

void expectNothingUntold(const std::string& name, const DiskTally& tally) {
  SCOPED_TRACE(name);
  EXPECT_EQ(tally.not_finite, 0);
  EXPECT_EQ(tally.unreported, 0);
  EXPECT_EQ(tally.placed + tally.lost(), tally.queries);
  EXPECT_GT(tally.placed, tally.queries / 4);
}

TEST(DiskCheck, LeavesNothingUntoldOnPrimitives) {
  expectNothingUntold("sphere", survey(geometry::makeSphere(0.04, 4), 16));
  expectNothingUntold("box", survey(geometry::makeBox({0.05, 0.07, 0.1}), 16));
  expectNothingUntold("cylinder", survey(geometry::makeCylinder(0.02, 0.1, 32), 16));
}

TEST(DiskCheck, LeavesNothingUntoldOnShippedObjects) {
  for (const char* name : {"box", "lemon", "scissors", "wine_glass"}) {
    const auto path = test::sourceDirectory() / "server/models/objects" / name;
    expectNothingUntold(name, survey(io::readMesh(path.string() + ".obj").mesh, 8));
  }
}

TEST(DiskCheck, LeavesNothingUntoldOnScansAndCadMeshes) {
  HANDGRAFT_NEEDS_SHARED_DATA("objects");
  for (const char* name : {"objects/ycb_16k/037_scissors.stl", "objects/contactdb/mug.stl",
                           "hands/allegro_right/meshes/visual/link_3.0.obj"}) {
    if (!std::filesystem::exists(test::sharedData(name))) continue;
    expectNothingUntold(name, survey(io::readMesh(test::sharedData(name)).mesh, 8));
  }
}

// The judge itself: a clean disk has nothing to tell, and damage does what it says.
TEST(DiskCheck, SeesWhatIsThere) {
  const TriangleMesh sphere = geometry::makeSphere(0.04, 4);
  const DiskTally whole =
      checkDisk(*geometry::LogMapper::borrowing(sphere),
                randomRoots(sphere, 1, 1).front().point, 0.02, LogMapMethod::kExact);
  EXPECT_EQ(whole.placed, 25);
  EXPECT_EQ(whole.folded + whole.turned_over + whole.collapsed, 0);
  EXPECT_FALSE(broken(sphere, Damage::kDeleted, 1).isClosed());
  EXPECT_GT(broken(sphere, Damage::kDuplicated, 1).nonManifoldEdgeCount(), 0);
  EXPECT_GT(broken(sphere, Damage::kFlipped, 1).nonManifoldEdgeCount(), 0);
  EXPECT_GT(broken(sphere, Damage::kMerged, 1).nonManifoldEdgeCount(), 0);
}

}  // namespace
}  // namespace handgraft::bench
