// Every command runs on tiny meshes and prints what its README says; and the surfaces that log
// maps are measured on are what they claim to be. No figure is judged here.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/geometry/log_map.h"

#include "tests/bench/measured_surface.h"
#include "tests/bench/mesh_versions.h"
#include "tests/support/process.h"

namespace handgraft::bench {
namespace {

nlohmann::json jsonOf(const std::vector<std::string>& arguments) {
  const test::Finished bench = test::run(HANDGRAFT_BENCH, arguments);
  EXPECT_EQ(bench.exit_code, 0) << bench.err;
  return nlohmann::json::parse(bench.out, nullptr, false);
}

TEST(MeasuredSurface, IsFlatButForTheApex) {
  for (const MeasuredSurface& surface : measuredSurfaces(3000)) {
    if (surface.surface == "sphere") continue;
    SCOPED_TRACE(surface.surface + ", " + surface.version);
    const geometry::TriangleMesh& mesh = surface.mesh;
    EXPECT_EQ(mesh.nonManifoldEdgeCount(), 0);
    EXPECT_EQ(mesh.components().second, 1);
    int bent = 0;
    for (int v = 0; v < mesh.vertexCount(); ++v) {
      if (mesh.isBoundaryVertex(v)) continue;
      bent += std::abs(mesh.angleSum(v) - 2.0 * std::numbers::pi) > 1e-7 ? 1 : 0;
    }
    EXPECT_EQ(bent, surface.surface.rfind("cone", 0) == 0 ? 1 : 0);
  }
}

TEST(MeasuredSurface, LiesOnTheSphere) {
  for (const MeasuredSurface& surface : measuredSurfaces(3000)) {
    if (surface.surface != "sphere") continue;
    SCOPED_TRACE(surface.version);
    EXPECT_TRUE(surface.mesh.isClosed());
    EXPECT_EQ(surface.mesh.eulerCharacteristic(), 2);
    for (int v = 0; v < surface.mesh.vertexCount(); ++v)
      ASSERT_NEAR(surface.mesh.vertex(v).norm(), 1.0, 1e-12);
  }
}

TEST(MeasuredSurface, HasTheTrianglesItsVersionIsNamedFor) {
  for (const MeasuredSurface& surface : measuredSurfaces(3000)) {
    SCOPED_TRACE(surface.surface + ", " + surface.version);
    const geometry::TriangleMesh& mesh = surface.mesh;
    if (surface.version == "obtuse") {
      EXPECT_GT(obtuseShare(mesh), 0.7);
    }
    if (surface.version != "sliver") continue;
    int needles = 0;
    for (int f = 0; f < mesh.faceCount(); ++f) {
      double longest = 0.0;
      const Eigen::Vector3i face = mesh.face(f);
      for (int c = 0; c < 3; ++c)
        longest =
            std::max(longest, (mesh.vertex(face[c]) - mesh.vertex(face[(c + 1) % 3])).norm());
      const double twice_area = (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                                    .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                                    .norm();
      needles += twice_area < 0.02 * longest * longest ? 1 : 0;
    }
    EXPECT_GT(needles, mesh.faceCount() / 8);
  }
}

TEST(Bench, LogmapAccuracyMeasuresAllMethodsOnAllSurfaces) {
  const nlohmann::json bench = jsonOf({"logmap-accuracy", "--vertices", "300", "--json"});
  // Surfaces, versions, methods, and three kinds of source with their sum.
  ASSERT_EQ(bench["accuracy"].size(), 5U * 5U * 5U * 4U);
  for (const nlohmann::json& row : bench["accuracy"]) {
    EXPECT_EQ(row["refusal"], "") << row;
    EXPECT_GT(row["compared"], 0) << row;
    EXPECT_GE(row["r_max"], row["r_mean"]) << row;
    if (row["method"] == "exact" && row["surface"] != "sphere") {
      EXPECT_LT(row["r_max"], 1e-9) << row;
      EXPECT_LT(row["phi_max"], 1e-9) << row;
    }
  }
}

TEST(Bench, LogmapAccuracyPrintsTheTableOfTheReadme) {
  const test::Finished bench =
      test::run(HANDGRAFT_BENCH, {"logmap-accuracy", "--vertices", "300", "--markdown"});
  EXPECT_EQ(bench.exit_code, 0) << bench.err;
  EXPECT_EQ(bench.out.rfind("| surface |", 0), 0U) << bench.out;
  EXPECT_EQ(std::count(bench.out.begin(), bench.out.end(), '\n'), 2 + 25 + 3);
}

TEST(Bench, RefusesSizesOutOfRange) {
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"logmap-accuracy", "--vertices", "7"}).exit_code, 2);
}

}  // namespace
}  // namespace handgraft::bench
