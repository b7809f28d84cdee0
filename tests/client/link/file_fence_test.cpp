#include "client/link/file_fence.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/link/model_files.h"
#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A model's folder from a stranger beside files that are nobody's business.
class FileFenceTest : public testing::Test {
 protected:
  void SetUp() override {
    static int count = 0;
    home = test::scratchDirectory() / ("home" + std::to_string(++count));
    model = home / "downloads" / "hand";
    fs::create_directories(model / "urdf");
    fs::create_directories(model / "meshes");
    write(model / "meshes" / "palm.stl", "solid palm");
    write(home / "secret", "secret");
    write(home / "secret.stl", "solid secret");
    write(home / "secret.bin", "secret");
    write(home / "secret.yaml", "secret: 1");
    write(home / "secret.srdf", "<secret/>");
  }

  static void write(const fs::path& path, const std::string& text) {
    std::ofstream(path) << text;
  }

  /// What is said of a hand whose one mesh is written so; empty if it is sent.
  std::string objectionTo(const std::string& uri, const PackageMap& packages = {}) const {
    write(model / "urdf" / "hand.urdf", "<robot><mesh filename=\"" + uri + "\"/></robot>");
    return objectionToHand(packages);
  }

  std::string objectionToHand(const PackageMap& packages = {}) const {
    try {
      HandReading reading;
      reading.packages = packages;
      handFiles(model / "urdf" / "hand.urdf", reading);
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  }

  fs::path home;
  fs::path model;
};

TEST_F(FileFenceTest, RefusesWhatAUrdfNamesOutsideItsFolder) {
  fs::create_symlink(home / "secret.stl", model / "meshes" / "link.stl");
  fs::create_symlink(home / "secret", model / "meshes" / "plain.stl");
  fs::create_directory_symlink(home, model / "meshes" / "all");
  fs::create_directories(home / "downloads" / "hand" / "urdf" / "downloads");
  const std::string home_path = home.string();
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"file:///etc/passwd", "/etc/passwd"},
      {"/etc/passwd", "/etc/passwd"},
      {"../../../../../../../../../../etc/passwd", "/etc/passwd"},
      {"file://" + home_path + "/secret.stl", "secret.stl"},
      {home_path + "/secret.stl", "secret.stl"},
      {"../../../secret.stl", "secret.stl"},
      {"..%2f..%2f..%2fsecret.stl", "secret.stl"},
      {"../../../secret", "secret"},
      {"../meshes/link.stl", "secret.stl"},
      {"../meshes/plain.stl", "secret"},
      {"../meshes/all/secret.stl", "secret.stl"},
      {"package://hand/../../secret.stl", "secret.stl"},
      {"package://" + home.filename().string() + "/secret.stl", "secret.stl"},
  };
  for (const auto& [uri, named] : cases) {
    EXPECT_NE(objectionTo(uri), "") << uri;
    EXPECT_THAT(objectionTo(uri), HasSubstr(named)) << uri;
  }
}

TEST_F(FileFenceTest, TakesWhatBelongsToTheModel) {
  const std::string home_path = home.string();
  const fs::path other = home / "downloads" / "other_description";
  fs::create_directories(other / "meshes");
  write(other / "package.xml", "<package/>");
  write(other / "meshes" / "tip.stl", "solid tip");
  fs::create_symlink(model / "meshes" / "palm.stl", model / "meshes" / "same.STL");
  for (const std::string uri :
       {"../meshes/palm.stl", "package://hand/meshes/palm.stl", "../meshes/same.STL",
        "package://other_description/meshes/tip.stl"})
    EXPECT_EQ(objectionTo(uri), "") << uri;
  EXPECT_EQ(objectionTo("file://" + (model / "meshes/palm.stl").string()), "");
  EXPECT_EQ(objectionTo("package://mine/secret.stl", {{"mine", home}}), "")
      << "the user named that folder";
  EXPECT_NE(objectionTo("package://mine/secret", {{"mine", home}}), "");
}

TEST_F(FileFenceTest, RefusesLinksInPlaceOfWhatLiesBesideAUrdf) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"hand.srdf", "secret.srdf"},
      {"hand.srdf", "secret"},
      {"sites.yaml", "secret.yaml"},
      {"hand.sites.yaml", "secret"}};
  for (const auto& [beside, secret] : cases) {
    EXPECT_EQ(objectionTo("../meshes/palm.stl"), "");
    fs::create_symlink(home / secret, model / "urdf" / beside);
    EXPECT_THAT(objectionToHand(), HasSubstr(secret)) << beside;
    fs::remove(model / "urdf" / beside);
  }
}

TEST_F(FileFenceTest, RefusesAModelThatIsALinkToSomethingElse) {
  fs::create_symlink(home / "secret", model / "urdf" / "hand.urdf");
  EXPECT_THAT(objectionToHand(), HasSubstr("secret"));
}

TEST_F(FileFenceTest, RefusesBuffersOfAGltfOutsideItsFolder) {
  write(model / "buffer.bin", "data");
  fs::create_symlink(home / "secret.bin", model / "link.bin");
  const auto objection_to_buffer = [&](const std::string& uri) -> std::string {
    write(model / "cup.gltf", R"({"buffers":[{"uri":")" + uri + R"("}]})");
    try {
      objectFiles(model / "cup.gltf");
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  };
  EXPECT_EQ(objection_to_buffer("buffer.bin"), "");
  for (const std::string& uri : std::vector<std::string>{
           "../../secret.bin", "../../secret", "link.bin", "/etc/passwd", "file:///etc/passwd",
           "file://" + (home / "secret.bin").string()})
    EXPECT_NE(objection_to_buffer(uri), "") << uri;
}

TEST_F(FileFenceTest, SendsNoMaterialOrPictureThatAMeshNames) {
  write(model / "cup.obj", "mtllib /etc/passwd\nv 0 0 0\n");
  EXPECT_EQ(objectFiles(model / "cup.obj").files.size(), 1U);
  write(model / "cup.gltf", R"({"images":[{"uri":"../../../secret.png"}]})");
  EXPECT_EQ(objectFiles(model / "cup.gltf").files.size(), 1U);
}

}  // namespace
}  // namespace handgraft::client
