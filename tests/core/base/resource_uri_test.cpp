#include "core/base/resource_uri.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/environment_variable.h"
#include "tests/support/shared_data.h"

namespace handgraft {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

class ResourceUri : public testing::Test {
 protected:
  void SetUp() override {
    root = test::scratchDirectory() / "ros" / "my_hand";
    fs::create_directories(root / "urdf");
    fs::create_directories(root / "meshes" / "a b");
    std::ofstream(root / "meshes" / "palm.stl") << "solid";
    std::ofstream(root / "meshes" / "a b" / "tip.stl") << "solid";
  }

  fs::path root;
};

TEST_F(ResourceUri, FindsRelativePathsFromTheFileThatNamesThem) {
  EXPECT_TRUE(fs::equivalent(resolveResource("../meshes/palm.stl", root / "urdf", {}),
                             root / "meshes/palm.stl"));
}

TEST_F(ResourceUri, FindsAPackageAboveTheFile) {
  EXPECT_TRUE(
      fs::equivalent(resolveResource("package://my_hand/meshes/palm.stl", root / "urdf", {}),
                     root / "meshes/palm.stl"));
}

TEST_F(ResourceUri, PrefersThePackageTheUserNamed) {
  EXPECT_EQ(resolveResource("package://other/palm.stl", "/", {{"other", root / "meshes"}}),
            root / "meshes/palm.stl");
}

TEST_F(ResourceUri, ReadsFileUrisAndPercentEscapes) {
  EXPECT_EQ(resolveResource("file://" + (root / "meshes/a%20b/tip.stl").string(), "/", {}),
            root / "meshes/a b/tip.stl");
}

TEST_F(ResourceUri, SaysWhatIsMissing) {
  try {
    resolveResource("package://nowhere/palm.stl", root, {});
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("--package nowhere=DIR"), std::string::npos);
  }
  EXPECT_THROW(resolveResource("meshes/none.stl", root, {}), InvalidInput);
  EXPECT_THROW(resolveResource("https://example.org/palm.stl", root, {}), InvalidInput);
  EXPECT_THROW(resolveResource("package://", root, {}), InvalidInput);
  EXPECT_THROW(resolveResource("", root, {}), InvalidInput);
}

TEST(MeshUris, AreFoundOnceAndInOrder) {
  EXPECT_THAT(meshUrisIn(R"(<robot><!-- <mesh filename="old.stl"/> -->
      <mesh scale="1 1 1" filename="b.stl"/><mesh filename='a.stl'/>
      <mesh filename = "b.stl"/></robot>)"),
              ElementsAre("b.stl", "a.stl"));
}

TEST(MeshUris, SurviveDamagedText) {
  EXPECT_TRUE(meshUrisIn("<mesh filename=\"never closed").empty());
  EXPECT_TRUE(meshUrisIn("<!-- never closed <mesh filename='a'/>").empty());
  EXPECT_TRUE(meshUrisIn("").empty());
  EXPECT_TRUE(meshUrisIn("<mesh filename=a.stl/><mesh file_name='a'/><mesh =''/>").empty());
}

TEST(MeshUris, MayBeAMillionBytesLong) {
  const std::string uri(1'000'000, 'a');
  EXPECT_THAT(meshUrisIn("<mesh scale='1 1 1' filename = \"" + uri + "\"/>"),
              ::testing::ElementsAre(uri));
}

TEST(AmentPackages, AreTheSharesOfEveryPrefixTheFirstOfAName) {
  const fs::path root = test::scratchDirectory() / "ament";
  fs::create_directories(root / "a/share/hand_description");
  fs::create_directories(root / "b/share/hand_description");
  fs::create_directories(root / "b/share/other");
  const std::string list =
      (root / "a").string() + "::" + (root / "gone").string() + ":" + (root / "b").string();
  {
    const test::EnvironmentVariable prefixes("AMENT_PREFIX_PATH", list);
    EXPECT_EQ(amentPackages(),
              (PackageMap{{"hand_description", root / "a/share/hand_description"},
                          {"other", root / "b/share/other"}}));
  }
  const test::EnvironmentVariable none("AMENT_PREFIX_PATH", std::nullopt);
  EXPECT_TRUE(amentPackages().empty());
}

}  // namespace
}  // namespace handgraft
