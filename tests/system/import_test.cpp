// Hands and contact maps that nobody prepared, through all programs.

#include <array>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/mesh_file.h"

#include "tests/support/environment_variable.h"
#include "tests/support/shared_data.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

std::string contentsOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A built-in hand as a stranger's: in a folder of its own, under another name, without sites.
fs::path strangersHand(const std::string& built_in, const std::string& name) {
  const fs::path from = sourceDirectory() / "server" / "models" / "hands" / built_in;
  const fs::path folder = scratchDirectory() / name;
  fs::create_directories(folder);
  fs::copy(from, folder, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  fs::remove(folder / "sites.yaml");
  fs::rename(folder / (built_in + ".urdf"), folder / (name + ".urdf"));
  return folder / (name + ".urdf");
}

std::map<std::string, json> sitesOf(const json& hand) {
  std::map<std::string, json> sites;
  for (const json& site : hand.at("sites"))
    sites[site.at("name")] = site;
  return sites;
}

std::vector<std::string> namesOf(const json& patches) {
  std::vector<std::string> names;
  for (const json& patch : patches)
    names.push_back(patch.at("name"));
  return names;
}

class Import : public testing::Test {
 protected:
  void succeed(const std::vector<std::string>& arguments) const {
    const Finished finished = service.client(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
  }

  // Before the service: skins are made once for all tests of this process.
  EnvironmentVariable cache{"XDG_CACHE_HOME", scratchDirectory() / "cache"};
  Service service;
};

TEST_F(Import, SitesAreFoundWrittenEditedAndUsed) {
  const fs::path urdf = strangersHand("human20", "stranger");
  const fs::path sites = urdf.parent_path() / "sites.yaml";
  const fs::path picture = scratchDirectory() / "sites.png";
  const json found = service.ask(
      {"hand", "inspect", urdf.string(), "--sites", sites.string(), "--png", picture.string()});
  EXPECT_EQ(found.at("sites_found"), true);
  EXPECT_EQ(found.at("sites").size(), 6U);
  EXPECT_EQ(found.at("skin_report").at("valid"), true);
  EXPECT_EQ(found.at("digits").size(), 5U);
  for (const json& digit : found.at("digits")) {
    EXPECT_EQ(digit.at("named_by_file"), true) << digit;
    const json& segments = digit.at("segments");
    EXPECT_EQ(segments.size(), 3U) << digit;
    EXPECT_EQ(segments.back().at("name"), "distal");
    EXPECT_EQ(segments.back().at("link"), digit.at("name").get<std::string>() + "_distal");
  }
  EXPECT_EQ(contentsOf(picture).substr(1, 3), "PNG");

  std::string text = contentsOf(sites);
  const std::size_t at = text.find("\"little\"");
  ASSERT_NE(at, std::string::npos) << text;
  text.replace(at, 8, "\"pinky\"");
  std::ofstream(sites) << text;
  succeed({"load", "hand", urdf.string(), "--name", "edited"});
  const auto edited = sitesOf(service.ask({"models", "show", "hand", "edited"}));
  EXPECT_EQ(edited.count("pinky"), 1U);
  EXPECT_EQ(edited.count("little"), 0U);
  for (std::size_t k = 0; k < 3; ++k) {  // files have nine digits
    EXPECT_NEAR(edited.at("index").at("p_L_m")[k].get<double>(),
                sitesOf(found).at("index").at("p_L_m")[k].get<double>(), 1e-9);
  }
}

TEST_F(Import, AMirroredHandHasMirroredSites) {
  const fs::path urdf = strangersHand("human20", "right");
  const auto right = sitesOf(service.ask({"hand", "inspect", urdf.string()}));
  const json mirrored = service.ask({"hand", "inspect", urdf.string(), "--mirror"});
  EXPECT_EQ(mirrored.at("mirrored"), true);
  EXPECT_EQ(mirrored.at("name"), "right_mirrored") << "it must not pass for the other hand";
  const auto left = sitesOf(mirrored);
  ASSERT_EQ(left.size(), right.size());
  for (const auto& [name, site] : right) {
    ASSERT_EQ(left.count(name), 1U) << name;
    for (const auto& [key, tolerance] :
         {std::pair("p_L_m", 0.003), {"n_L", 0.2}, {"direction_L", 0.2}}) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double expected =
            (k == 0 ? -1.0 : 1.0) * site.at(key)[k].get<double>();  // x alone turns round
        EXPECT_NEAR(left.at(name).at(key)[k].get<double>(), expected, tolerance)
            << name << " " << key << " " << k;
      }
    }
  }
}

TEST_F(Import, ASkinReadBackIsClosed) {
  const fs::path ply = scratchDirectory() / "skin.ply";
  const json document = service.ask({"skin", "barrett8", "--out", ply.string(), "--png",
                                     (scratchDirectory() / "skin.png").string()});
  const io::MeshFile file = io::readMesh(ply);
  EXPECT_EQ(document.at("skin").at("valid"), true);
  EXPECT_EQ(document.at("skin").at("vertices"), file.mesh.vertexCount());
  EXPECT_EQ(document.at("skin").at("faces"), file.mesh.faceCount());
  EXPECT_TRUE(file.mesh.isClosed());
  EXPECT_EQ(file.mesh.nonManifoldEdgeCount(), 0);
  EXPECT_EQ(file.mesh.components().second, 1);
  EXPECT_EQ(file.mesh.eulerCharacteristic(), 2);
}

TEST_F(Import, UnitsInDoubtAreAskedForAndApplied) {
  std::ifstream in(sourceDirectory() / "server" / "models" / "objects" / "box.obj");
  const fs::path millimetres = scratchDirectory() / "box_in_mm.obj";
  {
    std::ofstream out(millimetres);
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string kind;
      std::array<double, 3> p{};
      if (words >> kind >> p[0] >> p[1] >> p[2] && kind == "v") {
        out << "v " << 1e3 * p[0] << ' ' << 1e3 * p[1] << ' ' << 1e3 * p[2] << '\n';
      } else {
        out << line << '\n';
      }
    }
  }
  const Finished refused = service.client({"load", "object", millimetres.string()});
  EXPECT_EQ(refused.exit_code, 2) << refused.out;
  EXPECT_THAT(refused.err, HasSubstr("--units mm"));
  succeed({"load", "object", millimetres.string(), "--units", "mm"});
  const json grasp = service.ask(
      {"grasp", "--hand", "barrett8", "--object", "box_in_mm", "--contacts",
       (sourceDirectory() / "server" / "models" / "contacts" / "box_5.json").string()});
  const json plain =
      service.ask({"grasp", "--hand", "barrett8", "--object", "box", "--contacts", "box_5"});
  EXPECT_NEAR(grasp.at("terms").at("objective"), plain.at("terms").at("objective"), 1e-2);
}

/// What comes before the segment in "index_distal".
std::set<std::string> digitsOf(const json& patches) {
  std::set<std::string> digits;
  for (const std::string& name : namesOf(patches))
    digits.insert(name.substr(0, name.find('_')));
  return digits;
}

TEST_F(Import, ContactsOfAPosedHandAreOfTheFingersThatItWasPosedBy) {
  const fs::path pose = scratchDirectory() / "pose.json";
  const fs::path set = scratchDirectory() / "touched.json";
  succeed({"grasp", "--hand", "human20", "--object", "lemon", "--contacts", "lemon_6", "--out",
           pose.string()});
  const json contacts = service.ask({"contacts", "from-pose", "--hand", "human20", "--pose",
                                     pose.string(), "--object", "lemon", "--out", set.string(),
                                     "--png", (scratchDirectory() / "touched.png").string()});
  EXPECT_THAT(digitsOf(contacts.at("patches")),
              testing::ElementsAre("index", "little", "middle", "palm", "ring", "thumb"));
  const json grasp = service.ask(
      {"grasp", "--hand", "human20", "--object", "lemon", "--contacts", set.string()});
  for (const json& patch : grasp.at("patches"))
    EXPECT_TRUE(patch.at("placed")) << patch;
}

TEST_F(Import, AnImportedSetGraspsAsItsMapDoes) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb/025_mug_grasp0_contact.ply");
  const std::string map = sharedData("contacts/dexycb/025_mug_grasp0_contact.ply").string();
  const std::string mug = sharedData("objects/ycb/025_mug.obj").string();
  const fs::path set = scratchDirectory() / "mug.json";
  const json imported =
      service.ask({"contacts", "import", map, "--object", mug, "--out", set.string(), "--png",
                   (scratchDirectory() / "mug.png").string()});
  EXPECT_THAT(imported.at("file").get<std::string>(),
              testing::HasSubstr("handgraft-contacts/"));
  const json by_map =
      service.ask({"grasp", "--hand", "human20", "--object", mug, "--contacts", map});
  const json by_set =
      service.ask({"grasp", "--hand", "human20", "--object", mug, "--contacts", set.string()});
  EXPECT_EQ(namesOf(by_map.at("patches")), namesOf(by_set.at("patches")));
  EXPECT_EQ(namesOf(imported.at("patches")).size(), by_map.at("patches").size());
  EXPECT_NEAR(by_set.at("terms").at("objective"), by_map.at("terms").at("objective"),
              1e-6 * by_map.at("terms").at("objective").get<double>());
}

TEST_F(Import, JointsTellWhichFingersHeldTheLightBulb) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose/full28_use_light_bulb_contact.ply");
  const fs::path folder = sharedData("contacts/contactpose");
  const std::string map = (folder / "full28_use_light_bulb_contact.ply").string();
  const json plain = service.ask({"contacts", "import", map, "--object", map});
  const json told = service.ask({"contacts", "import", map, "--object", map, "--joints",
                                 (folder / "full28_use_light_bulb.json").string()});
  EXPECT_EQ(namesOf(plain.at("patches"))[0], "c1") << "without joints nobody knows the fingers";
  EXPECT_THAT(digitsOf(told.at("patches")),
              testing::ElementsAre("index", "middle", "ring", "thumb"));
  EXPECT_NE(plain.at("name"), told.at("name"));
  for (const json& patch : told.at("patches")) {
    EXPECT_FALSE(patch.at("direction_O").is_null());
    EXPECT_EQ(patch.at("point_count"), 25U);
  }
}

}  // namespace
}  // namespace handgraft::test
