#include "client/gateway/given_files.h"

#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/link/client.h"
#include "core/base/error.h"

namespace handgraft::client::gateway {

namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr PageId kPage = 3;

class GivenFilesTest : public testing::Test {
 protected:
  void put(const std::string& path, const std::string& text) {
    given.put(kPage, {1, path, text.size(), 0, text});
  }

  ModelFiles hand(const std::string& mesh) {
    put("my_hand/urdf/hand.urdf",
        fmt::format(R"(<robot name="r"><link name="l"><mesh filename="{}"/></link></robot>)",
                    mesh));
    put("my_hand/meshes/palm.stl", "solid");
    return given.find(kPage, 1)->model(v1::MODEL_HAND, "my_hand/urdf/hand.urdf", "", "");
  }

  GivenFiles given;
};

TEST_F(GivenFilesTest, MakeAHandWithItsMeshes) {
  for (const char* mesh : {"../meshes/palm.stl", "package://my_hand/meshes/palm.stl",
                           "package://renamed/meshes/palm.stl"}) {
    GivenFiles fresh;
    given.drop(kPage);
    const ModelFiles model = hand(mesh);
    ASSERT_EQ(model.files.size(), 2u) << mesh;
    EXPECT_EQ(model.files[1].uri, mesh);
    EXPECT_EQ(readFile(model.files[1].path), "solid");
  }
}

TEST_F(GivenFilesTest, ReachNothingElseOfThisMachineAndTellNothingOfIt) {
  for (const char* mesh : {"file:///etc/passwd", "/etc/passwd", "../../../../../etc/passwd",
                           "package://etc/passwd", "package://my_hand/../../../../etc/passwd",
                           "package://my_hand/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
                           "package://other/../../../../../../etc/passwd"}) {
    given.drop(kPage);
    EXPECT_THAT(
        [&] {
          hand(mesh);
        },
        testing::ThrowsMessage<InvalidInput>(
            AllOf(HasSubstr("my_hand/urdf/hand.urdf"),
                  Not(HasSubstr(std::filesystem::temp_directory_path().string() + "/")))))
        << mesh;
  }
}

TEST_F(GivenFilesTest, SayWhichMeshIsMissing) {
  EXPECT_THAT(
      [&] {
        hand("../meshes/thumb.stl");
      },
      testing::ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("my_hand/urdf/hand.urdf: '../meshes/thumb.stl': no such file"),
                HasSubstr("'my_hand/meshes/thumb.stl'"))));
}

TEST_F(GivenFilesTest, AreCalledByPathsThatLeadNowhereElse) {
  for (const std::string path : {"", "/etc/passwd", "../out.stl", "a/../../out.stl", "a//b.stl",
                                 "a/./b.stl", "a/", "a\\..\\b.stl", ".."}) {
    EXPECT_THAT(
        [&] {
          put(path, "x");
        },
        testing::ThrowsMessage<InvalidInput>(HasSubstr("called by paths")))
        << path;
  }
  EXPECT_THROW(put(std::string(300, 'a'), "x"), InvalidInput);
  EXPECT_THROW(put(std::string("a\0b", 3), "x"), InvalidInput);
  std::string deep = "f";
  for (int i = 0; i < 40; ++i)
    deep.insert(0, "d/");
  EXPECT_THROW(put(deep, "x"), InvalidInput);
}

TEST_F(GivenFilesTest, ComeInOrderAndWhole) {
  given.put(kPage, {1, "lemon.obj", 6, 0, "abc"});
  EXPECT_THROW((void)given.find(kPage, 1), InvalidInput);
  EXPECT_THROW(given.put(kPage, {1, "lemon.obj", 6, 0, "abc"}), InvalidInput);
  EXPECT_THROW(given.put(kPage, {1, "lemon.obj", 6, 3, "defg"}), InvalidInput);
  given.put(kPage, {1, "lemon.obj", 6, 3, "def"});
  const ModelFiles model = given.find(kPage, 1)->model(v1::MODEL_OBJECT, "lemon.obj", "", "mm");
  EXPECT_EQ(readFile(model.files.at(0).path), "abcdef");
  EXPECT_EQ(model.name, "lemon");
  EXPECT_EQ(model.units, "mm");
  EXPECT_THROW((void)given.find(kPage + 1, 1), InvalidInput) << "pages do not see each other's";
}

TEST_F(GivenFilesTest, HaveRoomForSoMuchAndNotForMore) {
  GivenLimits limits;
  limits.bytes_per_page = 100;
  limits.bytes = 150;
  limits.files_per_group = 2;
  limits.groups_per_page = 2;
  GivenFiles few(limits);
  few.put(1, {1, "a", 60, 0, ""});
  EXPECT_THROW(few.put(1, {1, "b", 41, 0, ""}), Refused);
  EXPECT_THROW(few.put(1, {1, "b", ~0ULL, 0, ""}), Refused);
  few.put(1, {1, "b", 40, 0, ""});
  EXPECT_THROW(few.put(1, {1, "c", 0, 0, ""}), Refused) << "files";
  EXPECT_THROW(few.put(2, {1, "a", 51, 0, ""}), Refused) << "of all pages";
  few.put(1, {2, "a", 0, 0, ""});
  EXPECT_THROW(few.put(1, {3, "a", 0, 0, ""}), Refused) << "folders";
  few.drop(1);
  few.put(2, {2, "a", 51, 0, ""});
}

TEST_F(GivenFilesTest, GoFromTheDiskWithTheirPage) {
  put("lemon.obj", "v");
  const auto file =
      given.find(kPage, 1)->model(v1::MODEL_OBJECT, "lemon.obj", "", "").files.at(0).path;
  EXPECT_TRUE(std::filesystem::exists(file));
  given.drop(kPage);
  EXPECT_FALSE(std::filesystem::exists(file.parent_path()));
}

}  // namespace

}  // namespace handgraft::client::gateway
