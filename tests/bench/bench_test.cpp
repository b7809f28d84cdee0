// Every command runs on tiny meshes and prints what its README says; and the surfaces that log
// maps are measured on are what they claim to be. No figure is judged here.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/geometry/log_map.h"

#include "tests/bench/measured_surface.h"
#include "tests/bench/mesh_versions.h"
#include "tests/support/plates.h"
#include "tests/support/process.h"
#include "tests/support/shared_data.h"

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

TEST(Bench, LogmapSpeedMeasuresSpheresBesideCgal) {
  const nlohmann::json bench = jsonOf(
      {"logmap-speed", "--subdivisions", "4", "--roots", "2", "--repeats", "1", "--json"});
  ASSERT_EQ(bench["disks"].size(), 3U);  // fast, exact and CGAL
  for (const nlohmann::json& disk : bench["disks"]) {
    EXPECT_GT(disk["reached"], 200) << disk;
    EXPECT_GT(disk["ms_median"], 0.0) << disk;
    EXPECT_GE(disk["ms_high"], disk["ms_low"]) << disk;
    if (disk["method"] != "fast") {
      EXPECT_LT(disk["r_difference_m"], 1e-9) << disk;
    }
  }
  ASSERT_EQ(bench["growth"].size(), 4U);
  for (const nlohmann::json& growth : bench["growth"])
    EXPECT_EQ(growth["points"].size(), 4U);
}

TEST(Bench, LogmapSpeedMeasuresAllMethodsOnASkin) {
  const std::string cache = test::scratchDirectory() / "skins";
  const std::vector<std::string> arguments{
      "logmap-speed",
      "--hand",
      test::sourceDirectory() / "server/models/hands/barrett8/barrett8.urdf",
      "--vertices",
      "2500",
      "--roots",
      "2",
      "--repeats",
      "1",
      "--whole-roots",
      "1",
      "--subdivisions",
      "1",
      "--cache",
      cache,
      "--json"};
  const nlohmann::json bench = jsonOf(arguments);
  int on_skin = 0;
  for (const nlohmann::json& disk : bench["disks"]) {
    if (disk["surface"] == "unit sphere") continue;
    ++on_skin;
    EXPECT_NEAR(disk["vertices"].get<int>(), 2500, 75) << disk;
    EXPECT_GT(disk["reached"], 5) << disk;
    if (disk["method"] == "cgal exact" || disk["method"] == "cgal exact cut") {
      EXPECT_LT(disk["r_difference_m"], 1e-9) << disk;
    }
  }
  EXPECT_EQ(on_skin, 5 + 3);
  // The second run reads the skin that the first one kept.
  const nlohmann::json again = jsonOf(arguments);
  EXPECT_EQ(again["disks"][0]["reached"], bench["disks"][0]["reached"]);
}

TEST(Bench, TransferComesBackToItself) {
  const nlohmann::json bench =
      jsonOf({"transfer", "--smooth-vertices", "1000", "--repeats", "1", "--json"});
  EXPECT_EQ(bench["transfer"].size(), 0U);      // no hand was given
  ASSERT_EQ(bench["round_trips"].size(), 12U);  // three surfaces, both ways, fast and exact
  for (const nlohmann::json& trip : bench["round_trips"]) {
    EXPECT_GT(trip["points"], 200) << trip;
    EXPECT_LT(trip["mean_mm"], 0.1) << trip;
  }
}

TEST(Bench, TransferTimesEveryStageOnAHand) {
  const std::string models = test::sourceDirectory() / "server/models";
  const nlohmann::json bench =
      jsonOf({"transfer", "--hand", models + "/hands/barrett8/barrett8.urdf", "--object",
              models + "/objects/lemon.obj", "--contacts", models + "/contacts/lemon_6.json",
              "--vertices", "2500", "--smooth-vertices", "300", "--repeats", "1", "--cache",
              test::scratchDirectory() / "skins", "--json"});
  EXPECT_EQ(bench["patches"], 6);
  ASSERT_EQ(bench["transfer"].size(), 3U);
  for (const nlohmann::json& method : bench["transfer"]) {
    EXPECT_EQ(method["points"].get<int>() + method["lost"].get<int>(), 6 * 25) << method;
    EXPECT_GE(method["stages"].size(), 7U);
  }
}

TEST(Bench, SurveyCountsEveryPointOfEveryMesh) {
  const std::string objects = test::sourceDirectory() / "server/models/objects";
  const nlohmann::json bench = jsonOf({"survey", objects, "--patches", "4", "--methods", "fast",
                                       "auto", "--damaged", "--json"});
  EXPECT_EQ(bench["unread"].size(), 0U);
  ASSERT_GT(bench["meshes"].size(), 0U);
  EXPECT_EQ(bench["meshes"].size() % (2 * 5 * 4), 0U);  // methods, damages, radii
  for (const nlohmann::json& mesh : bench["meshes"]) {
    EXPECT_EQ(mesh["disks"].get<int>() + mesh["refused"].get<int>(), 1) << mesh;
    EXPECT_EQ(mesh["points"], 25 * mesh["disks"].get<int>()) << mesh;
    EXPECT_EQ(mesh["placed"].get<int>() + mesh["lost_at_edge"].get<int>() +
                  mesh["lost_at_cut_locus"].get<int>() + mesh["lost_beyond"].get<int>(),
              mesh["points"])
        << mesh;
  }
}

TEST(Bench, ImportMeasuresAHandOfTheLibrary) {
  const std::string folder = test::sourceDirectory() / "server/models/hands/barrett8";
  const nlohmann::json bench = jsonOf({"import", folder, "--poses", "5", "--json"});
  ASSERT_EQ(bench["hands"].size(), 1U);
  const nlohmann::json& hand = bench["hands"][0];
  EXPECT_EQ(hand["refused"], "");
  EXPECT_EQ(hand["dofs"], 8);
  EXPECT_EQ(hand["mimics"], 0);
  EXPECT_LT(hand["pose_difference"], 1e-9);
  EXPECT_EQ(hand["skin"]["valid"], true);
  EXPECT_EQ(hand["digits"], 3);
  EXPECT_EQ(hand["pads"], 3);
  EXPECT_EQ(hand["sites_on_the_back"], 0);
  ASSERT_EQ(hand["sites"].size(), 4U);
  for (const nlohmann::json& site : hand["sites"]) {
    EXPECT_LT(site["off_closing_deg"], 60.0) << site;
    EXPECT_LT(site["to_given_mm"], 20.0) << site;  // the library's own are on all of them
  }
}

TEST(Bench, ImportSplitsAContactMap) {
  // A disk of 10 mm on a plate, called a thumb's.
  const geometry::TriangleMesh plate = test::makePlate(40, 40, 0.001);
  const std::filesystem::path folder = test::scratchDirectory() / "maps";
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / "plate_contact.ply");
  file << "ply\nformat ascii 1.0\ncomment 0=thumb\nelement vertex " << plate.vertexCount()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty float contact\n"
       << "property int link\nelement face " << plate.faceCount()
       << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int v = 0; v < plate.vertexCount(); ++v) {
    const bool touches = plate.vertex(v).norm() < 0.010;
    file << plate.vertex(v).transpose() << (touches ? " 1 0\n" : " 0 -1\n");
  }
  for (int f = 0; f < plate.faceCount(); ++f)
    file << "3 " << plate.face(f).transpose() << "\n";
  file.close();

  const nlohmann::json bench = jsonOf({"import", folder, "--json"});
  ASSERT_EQ(bench["contact_maps"].size(), 1U);
  const nlohmann::json& map = bench["contact_maps"][0];
  EXPECT_EQ(map["touching"], nlohmann::json({"thumb"}));
  EXPECT_EQ(map["patches"], nlohmann::json({"thumb"}));
  EXPECT_EQ(map["points"], 25);
  EXPECT_LT(map["off_boundary_mm"], 1e-6);
  // Faces whole inside the disk: those of one of 9 mm are, too.
  EXPECT_GT(map["mean_area_mm2"], 254.0);
  EXPECT_LT(map["mean_area_mm2"], 314.2);
  EXPECT_EQ(map["compared"], 0);  // nobody recorded joints
}

TEST(Bench, ChainGoesFromFilesToAPose) {
  const std::string models = test::sourceDirectory() / "server/models";
  const nlohmann::json bench =
      jsonOf({"chain", "--hand", models + "/hands/barrett8/barrett8.urdf", "--object",
              models + "/objects/lemon.obj", "--contacts", models + "/contacts/lemon_6.json",
              "--cache", test::scratchDirectory() / "skins", "--json"});
  ASSERT_EQ(bench["chain"].size(), 1U);
  const nlohmann::json& grasp = bench["chain"][0];
  EXPECT_EQ(grasp["refused"], "");
  double sum_mm = 0.0;
  int points = 0;
  std::vector<std::string> dropped;
  for (const nlohmann::json& patch : grasp["patches"]) {
    if (patch["dropped"] != "") {
      dropped.push_back(patch["name"]);
      continue;
    }
    EXPECT_EQ(patch["points"].get<int>() + patch["lost"].get<int>(), 25) << patch;
    sum_mm += patch["points"].get<int>() * patch["mean_mm"].get<double>();
    points += patch["points"].get<int>();
  }
  EXPECT_EQ(dropped, (std::vector<std::string>{"middle", "little"}));
  EXPECT_EQ(grasp["points"], points);
  EXPECT_NEAR(grasp["mean_mm"].get<double>(), sum_mm / points, 1e-9);
  EXPECT_LT(grasp["mean_mm"], 30.0);  // a lemon is 60 mm across
}

TEST(Bench, RefusesWrongInput) {
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"survey", "/no/such/folder"}).exit_code, 2);
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"logmap-accuracy", "--vertices", "7"}).exit_code, 2);
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"logmap-speed", "--roots", "0"}).exit_code, 2);
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"transfer", "--hand", "x.urdf"}).exit_code, 2);
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"import", "/no/such/folder"}).exit_code, 2);
  EXPECT_EQ(test::run(HANDGRAFT_BENCH, {"chain", "--object", "x.obj"}).exit_code, 2);
}

}  // namespace
}  // namespace handgraft::bench
