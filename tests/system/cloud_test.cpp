// Objects given as points alone, through all programs.

#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The vertices of an OBJ as a PLY without faces, in their order.
std::filesystem::path cloudOf(const std::filesystem::path& obj) {
  std::ifstream in(obj);
  std::ostringstream points;
  int count = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("v ", 0) != 0) continue;
    points << line.substr(2) << '\n';
    ++count;
  }
  const std::filesystem::path path = scratchDirectory() / "cloud.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex " << count
                      << "\nproperty double x\nproperty double y\nproperty double z\n"
                      << "end_header\n"
                      << points.str();
  return path;
}

std::string notesIn(const json& document) {
  return document.at("notes").dump();
}

TEST(PointCloud, IsGraspedAsItsMeshIs) {
  const Service service;
  const auto models = sourceDirectory() / "server/models";
  const auto cloud = cloudOf(models / "objects/lemon.obj");

  const json loaded = service.ask({"load", "object", cloud.string(), "--name", "points"});
  EXPECT_THAT(notesIn(loaded), HasSubstr("points")) << loaded;
  EXPECT_THAT(notesIn(loaded), HasSubstr("mm")) << "how far the surface is from the points";

  // The same contact set: its vertices are the cloud's points.
  const auto contacts = (models / "contacts/lemon_6.json").string();
  const json on_mesh =
      service.ask({"grasp", "--hand", "human20", "--object", "lemon", "--contacts", "lemon_6"});
  const json on_cloud = service.ask(
      {"grasp", "--hand", "human20", "--object", cloud.string(), "--contacts", contacts});
  ASSERT_EQ(on_cloud.at("patches").size(), on_mesh.at("patches").size());
  for (std::size_t i = 0; i < on_mesh.at("patches").size(); ++i) {
    const json& mesh = on_mesh.at("patches")[i];
    const json& points = on_cloud.at("patches")[i];
    EXPECT_EQ(points.at("name"), mesh.at("name"));
    EXPECT_NEAR(points.at("mean_mm").get<double>(), mesh.at("mean_mm").get<double>(), 0.5)
        << mesh.at("name");
  }
}

TEST(PointCloud, OfTooFewPointsIsRefused) {
  const Service service;
  const auto path = scratchDirectory() / "few.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                         "property float y\nproperty float z\nend_header\n"
                         "0 0 0\n0.1 0 0\n0 0.1 0\n";
  const Finished finished = service.client({"load", "object", path.string()});
  EXPECT_EQ(finished.exit_code, 2) << finished.err;
  EXPECT_THAT(finished.err, HasSubstr("3 points"));
  EXPECT_NO_THROW((void)service.ask({"doctor"}));
}

}  // namespace
}  // namespace handgraft::test
