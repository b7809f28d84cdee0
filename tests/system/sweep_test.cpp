// Design studies through all programs: variants of a hand, and sweeps with table and picture.
#include <fstream>
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/service.h"
#include "tests/system/shared_skins.h"

namespace handgraft::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kHand = "tendon16";

std::string builtInSets() {
  return (sourceDirectory() / "server/models/contacts").string();
}

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');)
    cells.push_back(cell);
  return cells;
}

/// Rows of a CSV without quoted fields, by column.
std::vector<std::map<std::string, std::string>> tableIn(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = cellsOf(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = cellsOf(line);
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size() && i < names.size(); ++i)
      row[names[i]] = cells[i];
  }
  return rows;
}

TEST(Sweep, OfTheBuiltInGraspsGivesATableAndAPicture) {
  const SharedSkins skins;
  const Service service;
  const auto table = scratchDirectory() / "table.csv";
  const auto picture = scratchDirectory() / "plot.png";
  const json sweep = service.ask({"sweep", "--hand", kHand, "--contacts-dir", builtInSets(),
                                  "--vary", "index_middle_crease.upper=0.2:1.4:4", "--out",
                                  table.string(), "--png", picture.string()});
  EXPECT_EQ(sweep.at("format"), "handgraft-sweep/1");
  EXPECT_EQ(sweep.at("grasps").size(), 5u);
  ASSERT_EQ(sweep.at("rows").size(), 20u);

  const auto rows = tableIn(table);
  ASSERT_EQ(rows.size(), 20u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& row = rows[i];
    EXPECT_EQ(row.at("grasp"), sweep.at("grasps").at(i % 5).at("name"));
    EXPECT_EQ(row.at("error"), "");
    const double upper = std::stod(row.at("index_middle_crease.upper (rad)"));
    EXPECT_NEAR(upper, 0.2 + 0.4 * static_cast<double>(i / 5), 1e-9);
    EXPECT_LE(std::stod(row.at("index_middle_crease")), upper + 1e-9);
    EXPECT_NEAR(std::stod(row.at("mean_mm")), sweep.at("rows").at(i).at("mean_mm"), 1e-4);
    EXPECT_GT(std::stoi(row.at("patches")), 0);
  }
  std::ifstream png(picture, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(png), {}).substr(1, 3), "PNG");
}

TEST(Sweep, OfAMotionTellsInHowManyFramesEachPatchIsReached) {
  const SharedSkins skins;
  const Service service;
  const auto scratch = scratchDirectory();
  const std::string path = (scratch / "path.csv").string();
  std::ofstream(path)
      << "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n0.5,-0.05,0,0.3,1,0,0,0\n";
  const std::string file = (scratch / "pull.json").string();
  (void)service.ask({"motion", "join", "box_5", "box_5", "--path", path, "--rate", "30",
                     "--name", "pull", "--out", file});
  const auto table = scratch / "motion.csv";
  const std::vector<std::string> words = {"sweep",
                                          "--hand",
                                          kHand,
                                          "--motion",
                                          file,
                                          "--vary",
                                          "index_middle_crease.upper=0.1,1.4",
                                          "--out",
                                          table.string(),
                                          "--png",
                                          (scratch / "motion.png").string()};
  const json sweep = service.ask(words);
  ASSERT_EQ(sweep.at("grasps").size(), 6u) << "the motion and its five patches";
  ASSERT_EQ(sweep.at("rows").size(), 12u);
  for (const json& row : sweep.at("rows")) {
    EXPECT_EQ(row.at("error"), "");
    EXPECT_EQ(row.at("patch_count"), 16) << "frames";
    EXPECT_TRUE(row.at("joint_positions").empty());
  }
  EXPECT_EQ(sweep.at("grasps").at(1).at("patch"), "thumb");
  const auto rows = tableIn(table);
  ASSERT_EQ(rows.size(), 12u);
  EXPECT_EQ(rows[1].at("grasp"), "pull/thumb");
  // The motion that the server has by now is as good, beside a folder of grasps.
  const json both =
      service.ask({"sweep", "--hand", kHand, "--contacts-dir", builtInSets(), "--motion",
                   "pull", "--vary", "index_middle_crease.upper=1.4"});
  ASSERT_EQ(both.at("rows").size(), 11u);
  EXPECT_EQ(both.at("rows").at(6).at("reached_count"),
            sweep.at("rows").at(7).at("reached_count"));
  const Finished other = service.client(
      {"sweep", "--hand", kHand, "--motion", "nowhere", "--vary", "hand.size=1"});
  EXPECT_NE(other.exit_code, 0);
  EXPECT_THAT(other.err, HasSubstr("nowhere"));
}

TEST(Sweep, ARowAloneIsThatOfTheWholeSweep) {
  const SharedSkins skins;
  const Service service;
  const auto rows_of = [&](const std::string& values) {
    json rows = service
                    .ask({"sweep", "--hand", kHand, "--contacts-dir", builtInSets(), "--vary",
                          "thumb_proximal.length=" + values})
                    .at("rows");
    for (json& row : rows)
      row.erase("solve_ms");
    return rows;
  };
  const json all = rows_of("0.8,1.2");
  const json alone = rows_of("1.2");
  for (std::size_t grasp = 0; grasp < 5; ++grasp)
    EXPECT_EQ(all.at(5 + grasp), alone.at(grasp));
}

TEST(Sweep, SaysWhatIsWrong) {
  const SharedSkins skins;
  const Service service;
  const Finished joint = service.client({"sweep", "--hand", kHand, "--contacts-dir",
                                         builtInSets(), "--vary", "elbow.upper=0:1:3"});
  EXPECT_EQ(joint.exit_code, 2);
  EXPECT_THAT(joint.err, HasSubstr("'elbow'"));
  const Finished form = service.client(
      {"sweep", "--hand", kHand, "--contacts-dir", builtInSets(), "--vary", "thumb"});
  EXPECT_EQ(form.exit_code, 2);
  EXPECT_THAT(form.err, HasSubstr("FROM:TO:COUNT"));
  const Finished folder =
      service.client({"sweep", "--hand", kHand, "--contacts-dir", "/nowhere", "--vary",
                      "index_middle_crease.upper=0:1:3"});
  EXPECT_EQ(folder.exit_code, 2);
  EXPECT_THAT(folder.err, HasSubstr("/nowhere"));
}

TEST(Vary, MakesAHandThatGrasps) {
  const SharedSkins skins;
  const Service service;
  const auto urdf = scratchDirectory() / "longer.urdf";
  const json made = service.ask({"hand", "vary", kHand, "--set", "index_middle.length=1.2",
                                 "--set", "index_middle_crease.upper=60deg", "--name", "longer",
                                 "--urdf", urdf.string()});
  EXPECT_TRUE(made.at("skin_report").at("valid").get<bool>()) << made.at("skin_report");
  std::ifstream file(urdf);
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(file), {}),
              HasSubstr("upper=\"1.047197551"));
  const json grasp =
      service.ask({"grasp", "--hand", "longer", "--object", "lemon", "--contacts", "lemon_6"});
  EXPECT_LE(grasp.at("joints").at("index_middle_crease").get<double>(), 1.0472);
  EXPECT_EQ(service.client({"unload", "hand", "longer"}).exit_code, 0);
}

}  // namespace
}  // namespace handgraft::test
