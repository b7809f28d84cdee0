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
    home_ = test::scratchDirectory() / ("home" + std::to_string(++count));
    model_ = home_ / "downloads" / "hand";
    fs::create_directories(model_ / "urdf");
    fs::create_directories(model_ / "meshes");
    write(model_ / "meshes" / "palm.stl", "solid palm");
    write(home_ / "secret", "secret");
    write(home_ / "secret.stl", "solid secret");
    write(home_ / "secret.bin", "secret");
    write(home_ / "secret.yaml", "secret: 1");
    write(home_ / "secret.srdf", "<secret/>");
  }

  static void write(const fs::path& path, const std::string& text) {
    std::ofstream(path) << text;
  }

  /// What is said of a hand whose one mesh is written so; empty if it is sent.
  std::string objectionTo(const std::string& uri, const PackageMap& packages = {}) const {
    write(model_ / "urdf" / "hand.urdf", "<robot><mesh filename=\"" + uri + "\"/></robot>");
    return objectionToHand(packages);
  }

  std::string objectionToHand(const PackageMap& packages = {}) const {
    try {
      HandReading reading;
      reading.packages = packages;
      handFiles(model_ / "urdf" / "hand.urdf", reading);
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  }

  fs::path home_;
  fs::path model_;
};

TEST_F(FileFenceTest, RefusesWhatAUrdfNamesOutsideItsFolder) {
  fs::create_symlink(home_ / "secret.stl", model_ / "meshes" / "link.stl");
  fs::create_symlink(home_ / "secret", model_ / "meshes" / "plain.stl");
  fs::create_directory_symlink(home_, model_ / "meshes" / "all");
  fs::create_directories(home_ / "downloads" / "hand" / "urdf" / "downloads");
  const std::string home = home_.string();
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"file:///etc/passwd", "/etc/passwd"},
      {"/etc/passwd", "/etc/passwd"},
      {"../../../../../../../../../../etc/passwd", "/etc/passwd"},
      {"file://" + home + "/secret.stl", "secret.stl"},
      {home + "/secret.stl", "secret.stl"},
      {"../../../secret.stl", "secret.stl"},
      {"..%2f..%2f..%2fsecret.stl", "secret.stl"},
      {"../../../secret", "secret"},
      {"../meshes/link.stl", "secret.stl"},
      {"../meshes/plain.stl", "secret"},
      {"../meshes/all/secret.stl", "secret.stl"},
      {"package://hand/../../secret.stl", "secret.stl"},
      {"package://" + home_.filename().string() + "/secret.stl", "secret.stl"},
  };
  for (const auto& [uri, named] : cases) {
    EXPECT_NE(objectionTo(uri), "") << uri;
    EXPECT_THAT(objectionTo(uri), HasSubstr(named)) << uri;
  }
}

TEST_F(FileFenceTest, TakesWhatBelongsToTheModel) {
  const std::string home = home_.string();
  const fs::path other = home_ / "downloads" / "other_description";
  fs::create_directories(other / "meshes");
  write(other / "package.xml", "<package/>");
  write(other / "meshes" / "tip.stl", "solid tip");
  fs::create_symlink(model_ / "meshes" / "palm.stl", model_ / "meshes" / "same.STL");
  for (const std::string uri :
       {"../meshes/palm.stl", "package://hand/meshes/palm.stl", "../meshes/same.STL",
        "package://other_description/meshes/tip.stl"})
    EXPECT_EQ(objectionTo(uri), "") << uri;
  EXPECT_EQ(objectionTo("file://" + (model_ / "meshes/palm.stl").string()), "");
  EXPECT_EQ(objectionTo("package://mine/secret.stl", {{"mine", home_}}), "")
      << "the user named that folder";
  EXPECT_NE(objectionTo("package://mine/secret", {{"mine", home_}}), "");
}

TEST_F(FileFenceTest, RefusesLinksInPlaceOfWhatLiesBesideAUrdf) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"hand.srdf", "secret.srdf"},
      {"hand.srdf", "secret"},
      {"sites.yaml", "secret.yaml"},
      {"hand.sites.yaml", "secret"}};
  for (const auto& [beside, secret] : cases) {
    EXPECT_EQ(objectionTo("../meshes/palm.stl"), "");
    fs::create_symlink(home_ / secret, model_ / "urdf" / beside);
    EXPECT_THAT(objectionToHand(), HasSubstr(secret)) << beside;
    fs::remove(model_ / "urdf" / beside);
  }
}

TEST_F(FileFenceTest, RefusesAModelThatIsALinkToSomethingElse) {
  fs::create_symlink(home_ / "secret", model_ / "urdf" / "hand.urdf");
  EXPECT_THAT(objectionToHand(), HasSubstr("secret"));
}

TEST_F(FileFenceTest, RefusesBuffersOfAGltfOutsideItsFolder) {
  write(model_ / "buffer.bin", "data");
  fs::create_symlink(home_ / "secret.bin", model_ / "link.bin");
  const auto objectionToBuffer = [&](const std::string& uri) -> std::string {
    write(model_ / "cup.gltf", R"({"buffers":[{"uri":")" + uri + R"("}]})");
    try {
      objectFiles(model_ / "cup.gltf");
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  };
  EXPECT_EQ(objectionToBuffer("buffer.bin"), "");
  for (const std::string& uri : std::vector<std::string>{
           "../../secret.bin", "../../secret", "link.bin", "/etc/passwd", "file:///etc/passwd",
           "file://" + (home_ / "secret.bin").string()})
    EXPECT_NE(objectionToBuffer(uri), "") << uri;
}

TEST_F(FileFenceTest, SendsNoMaterialOrPictureThatAMeshNames) {
  write(model_ / "cup.obj", "mtllib /etc/passwd\nv 0 0 0\n");
  EXPECT_EQ(objectFiles(model_ / "cup.obj").files.size(), 1U);
  write(model_ / "cup.gltf", R"({"images":[{"uri":"../../../secret.png"}]})");
  EXPECT_EQ(objectFiles(model_ / "cup.gltf").files.size(), 1U);
}

}  // namespace
}  // namespace handgraft::client
