#include "client/link/model_files.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/environment_variable.h"
#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class ModelFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    static int count = 0;
    root = test::scratchDirectory() / ("case" + std::to_string(++count)) / "my_hand";
    fs::create_directories(root / "urdf");
    fs::create_directories(root / "meshes" / "visual");
    write("meshes/visual/palm.stl", "solid palm");
    write("urdf/tip.obj", "v 0 0 0");
  }

  void write(const std::string& path, const std::string& text) const {
    std::ofstream(root / path) << text;
  }

  fs::path urdf(const std::string& body) const {
    write("urdf/hand.urdf", "<robot>" + body + "</robot>");
    return root / "urdf" / "hand.urdf";
  }

  static std::vector<std::string> urisOf(const ModelFiles& model) {
    std::vector<std::string> uris;
    for (const UploadFile& file : model.files)
      uris.push_back(file.uri);
    return uris;
  }

  fs::path root;
};

TEST_F(ModelFilesTest, TakesEveryMeshAsTheUrdfSpellsIt) {
  const ModelFiles model =
      handFiles(urdf(R"(<mesh filename="package://my_hand/meshes/visual/palm.stl"/>
              <mesh filename="../meshes/visual/palm.stl"/><mesh filename="tip.obj"/>)"),
                {});
  EXPECT_EQ(model.name, "hand");
  EXPECT_EQ(model.main_uri, "hand.urdf");
  EXPECT_THAT(urisOf(model),
              ElementsAre("hand.urdf", "package://my_hand/meshes/visual/palm.stl",
                          "../meshes/visual/palm.stl", "tip.obj"));
  EXPECT_TRUE(fs::equivalent(model.files[1].path, root / "meshes/visual/palm.stl"));
  EXPECT_TRUE(fs::equivalent(model.files[2].path, root / "meshes/visual/palm.stl"));
}

TEST_F(ModelFilesTest, NotesTheFolderOfAPackageThatItFound) {
  const ModelFiles model =
      handFiles(urdf(R"(<mesh filename="package://my_hand/meshes/visual/palm.stl"/>)"), {});
  ASSERT_EQ(model.packages.count("my_hand"), 1U);
  EXPECT_TRUE(model.packages.at("my_hand").is_absolute());
  EXPECT_TRUE(fs::equivalent(model.packages.at("my_hand"), root));
}

TEST_F(ModelFilesTest, FollowsThePackagesThatTheUserNamed) {
  const ModelFiles model = handFiles(urdf(R"(<mesh filename="package://other/palm.stl"/>)"),
                                     {{{"other", root / "meshes" / "visual"}}, {}, {}});
  EXPECT_TRUE(fs::equivalent(model.files.at(1).path, root / "meshes/visual/palm.stl"));
  EXPECT_TRUE(fs::equivalent(model.packages.at("other"), root / "meshes" / "visual"));
}

TEST_F(ModelFilesTest, TakesTheSitesBesideTheUrdf) {
  write("urdf/sites.yaml", "format: handgraft-sites/1");
  EXPECT_THAT(urisOf(handFiles(urdf(""), {})), ElementsAre("hand.urdf", "sites.yaml"));
}

TEST_F(ModelFilesTest, TakesSitesOfTheUrdfsNameBeforeThoseOfTheFolder) {
  const fs::path file = urdf("");
  write("urdf/sites.yaml", "format: handgraft-sites/1");
  write("urdf/hand.sites.yaml", "format: handgraft-sites/1");
  const ModelFiles files = handFiles(file, {});
  EXPECT_THAT(urisOf(files), ElementsAre("hand.urdf", "sites.yaml"));
  EXPECT_TRUE(fs::equivalent(files.files.back().path, root / "urdf/hand.sites.yaml"));
}

TEST_F(ModelFilesTest, TakesTheSrdfBesideTheUrdfUnlessToldAnother) {
  const fs::path file = urdf("");
  EXPECT_FALSE(handFiles(file, {}).hand_options.has_value());
  write("urdf/hand.srdf", "<robot/>");
  write("other.srdf", "<robot name='other'/>");
  const ModelFiles beside = handFiles(file, {});
  ASSERT_TRUE(beside.hand_options.has_value());
  EXPECT_TRUE(fs::equivalent(beside.files.back().path, root / "urdf/hand.srdf"));
  EXPECT_EQ(beside.files.back().uri, beside.hand_options->srdf_uri());
  HandReading reading;
  reading.srdf = root / "other.srdf";
  const ModelFiles told = handFiles(file, reading);
  EXPECT_TRUE(fs::equivalent(told.files.back().path, root / "other.srdf"));
  EXPECT_EQ(told.files.size(), 2U);
  reading.srdf = root / "gone.srdf";
  EXPECT_THROW(handFiles(file, reading), InvalidInput);
}

TEST_F(ModelFilesTest, SendsWhatOptionsOfAContactMapName) {
  write("map.ply", "ply");
  write("bulb.png", "png");
  write("hand.json", "[]");
  ContactReading reading;
  EXPECT_FALSE(contactFiles(root / "map.ply", "bulb", reading).contact_options.has_value());
  reading.picture = root / "bulb.png";
  reading.joints = root / "hand.json";
  reading.options.color_scale("jet");
  const ModelFiles model = contactFiles(root / "map.ply", "bulb", reading, "mm");
  ASSERT_TRUE(model.contact_options.has_value());
  EXPECT_THAT(urisOf(model), ElementsAre("map.ply", model.contact_options->picture_uri(),
                                         model.contact_options->joints_uri()));
  EXPECT_EQ(model.contact_options->color_scale(), "jet");
  EXPECT_EQ(model.units, "mm");
}

TEST_F(ModelFilesTest, APictureGivenAsContactsIsToldToGoWithItsMesh) {
  write("touched.PNG", "png");
  EXPECT_THAT(
      [&] {
        (void)contactFiles(root / "touched.PNG", "bulb");
      },
      testing::ThrowsMessage<InvalidInput>(testing::HasSubstr(
          "touched.PNG': a picture is no contact map by itself; give the mesh that it lies on, "
          "and the picture as --picture FILE --colors SCALE")));
}

TEST_F(ModelFilesTest, ComplaintsNameFilesAsTheyWereGiven) {
  write("pull.csv", "time_s");
  write("hand.json", "[]");
  const ModelFiles plan = plannedMotion(
      "pull", "{}", {{"path.csv", root / "pull.csv"}, {"did/hand.json", root / "hand.json"}});
  EXPECT_EQ(byGivenPaths("'plan.json': 'path.csv': line 3 is short", plan),
            quoted((root / "pull.csv").string()) + ": line 3 is short");
  EXPECT_EQ(byGivenPaths("'did/hand.json': no joints", plan),
            quoted((root / "hand.json").string()) + ": no joints");
  write("map.ply", "ply");
  const ModelFiles map = contactFiles(root / "map.ply", "bulb");
  EXPECT_EQ(byGivenPaths("'map.ply': no faces", map), "'map.ply': no faces");
}

TEST_F(ModelFilesTest, LooksForPackagesInTheWorkspaceLast) {
  const fs::path share = root.parent_path() / "prefix" / "share" / "installed";
  fs::create_directories(share);
  std::ofstream(share / "palm.stl") << "solid installed";
  const fs::path file = urdf(R"(<mesh filename="package://installed/palm.stl"/>)");
  EXPECT_THROW(handFiles(file, {}), InvalidInput);
  const test::EnvironmentVariable prefix("AMENT_PREFIX_PATH", root.parent_path() / "prefix");
  const ModelFiles found = handFiles(file, {});
  HandReading reading;
  reading.packages["installed"] = root / "meshes" / "visual";
  const ModelFiles told = handFiles(file, reading);
  EXPECT_TRUE(fs::equivalent(found.files.back().path, share / "palm.stl"));
  EXPECT_TRUE(fs::equivalent(found.packages.at("installed"), share));
  EXPECT_TRUE(fs::equivalent(told.files.back().path, root / "meshes/visual/palm.stl"));
}

TEST_F(ModelFilesTest, SaysHowToExpandXacro) {
  try {
    handFiles(urdf(R"(<mesh filename="package://my_hand/meshes/${side}.stl"/>)"), {});
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("xacro hand.urdf > "));
  }
}

TEST_F(ModelFilesTest, SaysWhichMeshOfWhichUrdfIsMissing) {
  try {
    handFiles(urdf(R"(<mesh filename="gone.stl"/>)"), {});
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("gone.stl"));
    EXPECT_THAT(error.what(), HasSubstr("hand.urdf"));
  }
}

TEST_F(ModelFilesTest, RefusesFilesThatAreNone) {
  EXPECT_THROW(handFiles(root / "no.urdf", {}), InvalidInput);
  EXPECT_THROW(objectFiles(root), InvalidInput);
  write("empty.obj", "");
  EXPECT_THROW(objectFiles(root / "empty.obj"), InvalidInput);
}

TEST_F(ModelFilesTest, TakesTheBuffersOfAGltfButNotItsPictures) {
  write("scene.bin", "bytes");
  write("scene.gltf", R"({"buffers":[{"uri":"scene.bin"},{"uri":"data:base64,AA"}],
                          "images":[{"uri":"wood.png"}]})");
  EXPECT_THAT(urisOf(objectFiles(root / "scene.gltf")), ElementsAre("scene.gltf", "scene.bin"));
}

TEST_F(ModelFilesTest, TakesAGltfWithMillionsOfBytesWrittenIntoIt) {
  write("scene.bin", "bytes");
  write("scene.gltf", R"({"buffers":[{"uri" : "data:base64,)" + std::string(5'000'000, 'A') +
                          R"("},{"uri":"scene.bin"}]})");
  EXPECT_THAT(urisOf(objectFiles(root / "scene.gltf")), ElementsAre("scene.gltf", "scene.bin"));
  write("long.gltf", R"({"buffers":[{"uri":")" + std::string(1'000'000, 'a') + R"("}]})");
  EXPECT_THROW(objectFiles(root / "long.gltf"), InvalidInput);
}

TEST_F(ModelFilesTest, TellsContentsApart) {
  write("a.obj", "v 1 0 0");
  const std::string before = nameApart(objectFiles(root / "a.obj"));
  EXPECT_EQ(nameApart(objectFiles(root / "a.obj")), before);
  write("a.obj", "v 2 0 0");
  EXPECT_NE(nameApart(objectFiles(root / "a.obj")), before);
}

TEST_F(ModelFilesTest, AreCalledByWhatTheyWereNamedBefore) {
  write("a.obj", "v 1 0 0");
  EXPECT_EQ(nameCalled(nameApart(objectFiles(root / "a.obj"))), "a");
  for (const char* own :
       {"", "-", "a", "left-hand", "hand-12345", "hand-0123456g", "-01234567"})
    EXPECT_EQ(nameCalled(own), own);
}

TEST_F(ModelFilesTest, TellsOneFileReadInDifferentWaysApart) {
  const fs::path file = urdf("");
  const std::string plain = nameApart(handFiles(file, {}));
  EXPECT_NE(nameApart(handFiles(file, {}, "mm")), plain);
  HandReading mirrored;
  mirrored.options.mirrored(true);
  HandReading loose;
  loose.options.skin().alpha_m(0.004);
  EXPECT_NE(nameApart(handFiles(file, mirrored)), plain);
  EXPECT_NE(nameApart(handFiles(file, loose)), plain);
  EXPECT_NE(nameApart(handFiles(file, loose)), nameApart(handFiles(file, mirrored)));
  write("map.ply", "ply");
  ContactReading strict;
  strict.options.threshold().push_back(0.5);
  EXPECT_NE(nameApart(contactFiles(root / "map.ply", "o", strict)),
            nameApart(contactFiles(root / "map.ply", "o")));
}

TEST_F(ModelFilesTest, KnowsPathsFromNames) {
  EXPECT_TRUE(isPath("lemon.obj"));
  EXPECT_TRUE(isPath("./lemon"));
  EXPECT_TRUE(isPath((root / "urdf" / "tip.obj").string()));
  EXPECT_FALSE(isPath("lemon"));
  EXPECT_FALSE(isPath("lemon_6"));
  EXPECT_FALSE(isPath("hand-1.0"));  // a version, no extension
  EXPECT_FALSE(isPath(""));
}

TEST(ModelNames, ComeFromTheFileAndStayHarmless) {
  EXPECT_EQ(nameFromPath("/a/006_mustard bottle.obj"), "006_mustard_bottle");
  EXPECT_EQ(nameFromPath("-x.obj"), "_x");
  for (const char* bad : {"", ".x", "-x", "a/b", "a b", "\xc3\xa4"}) {
    EXPECT_THROW(checkModelName(bad, "--name"), InvalidInput) << bad;
  }
  EXPECT_THROW(checkModelName(std::string(65, 'a'), "--name"), InvalidInput);
  EXPECT_NO_THROW(checkModelName(nameFromPath("/a/..strange\n\xff.obj"), "--name"));
}

}  // namespace
}  // namespace handgraft::client
