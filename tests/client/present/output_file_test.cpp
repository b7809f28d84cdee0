#include "client/present/output_file.h"

#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "client/link/model_files.h"
#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputFile : public testing::Test {
 protected:
  void SetUp() override {
    static int count = 0;
    folder = test::scratchDirectory() / ("output" + std::to_string(++count));
    fs::create_directories(folder);
  }

  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  static std::string objectionTo(const fs::path& path) {
    try {
      requireWritable({"--out", path});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder;
};

TEST_F(OutputFile, ReplacesAFileAndKeepsItsPermissions) {
  const fs::path file = folder / "a.json";
  writeFile(file, "{}, and more\n");
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  writeFile(file, "[]\n");
  EXPECT_EQ(readFile(file), "[]\n");
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(entries(), 1U);
}

TEST_F(OutputFile, ReportsADeviceThatTakesNothingAndLeavesIt) {
  EXPECT_EQ(objectionTo("/dev/full"), "");
  EXPECT_THROW(writeFile("/dev/full", "text"), InvalidInput);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_NO_THROW(writeFile("/dev/null", "text"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputFile, WritesIntoAPipe) {
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] {
    std::ifstream in(pipe);
    read.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  });
  writeFile(pipe, "through");
  reader.join();
  EXPECT_EQ(read, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(OutputFile, FollowsLinksAlsoToWhatIsNotThereYet) {
  fs::create_directories(folder / "far");
  writeFile(folder / "far" / "old", "old");
  fs::create_symlink("far/old", folder / "to_old");
  fs::create_symlink("far/new", folder / "to_new");
  fs::create_symlink("to_new", folder / "twice");
  writeFile(folder / "to_old", "1");
  writeFile(folder / "twice", "2");
  EXPECT_TRUE(fs::is_symlink(folder / "to_old"));
  EXPECT_TRUE(fs::is_symlink(folder / "to_new"));
  EXPECT_EQ(readFile(folder / "far" / "old"), "1");
  EXPECT_EQ(readFile(folder / "far" / "new"), "2");
}

TEST_F(OutputFile, RefusesWhatCannotBeWritten) {
  const fs::path file = folder / "mine.json";
  writeFile(file, "mine");
  fs::permissions(file, fs::perms::owner_read);
  EXPECT_THAT(objectionTo(file), HasSubstr("mine.json"));
  EXPECT_THROW(writeFile(file, "yours"), InvalidInput);
  EXPECT_EQ(readFile(file), "mine");
  EXPECT_THAT(objectionTo(""), HasSubstr("--out ''"));
  EXPECT_THAT(objectionTo(folder), HasSubstr("folder"));
  EXPECT_THAT(objectionTo(folder / "no" / "a"), HasSubstr("no folder"));
  EXPECT_THAT(objectionTo(file / "a"), HasSubstr("--out"));
  fs::create_symlink("loop", folder / "loop");
  EXPECT_THAT(objectionTo(folder / "loop"), HasSubstr("loop"));
  EXPECT_EQ(objectionTo(folder / "new.json"), "");
  EXPECT_EQ(entries(), 2U);  // checks write nothing
}

TEST_F(OutputFile, KnowsOneFileByTwoNames) {
  fs::create_symlink("new", folder / "link");
  const auto same = [&](const fs::path& a, const fs::path& b) {
    try {
      requireDistinct({{"--out", a}, {"--png", b}});
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("--out and --png"));
      return true;
    }
    return false;
  };
  EXPECT_TRUE(same(folder / "new", folder / "." / "new"));
  EXPECT_TRUE(same(folder / "link", folder / "new"));
  EXPECT_TRUE(same("relative", fs::absolute("relative")));
  EXPECT_FALSE(same(folder / "new", folder / "newer"));
  writeFile(folder / "new", "x");
  fs::create_hard_link(folder / "new", folder / "hard");
  EXPECT_TRUE(same(folder / "hard", folder / "link"));
}

TEST_F(OutputFile, KeepsNoOtherFromBeingWritten) {
  OutputFiles files;
  for (const fs::path& path : {fs::path("/dev/full"), folder / "ok", folder / "no" / "file"}) {
    files.write([&] {
      writeFile(path, "x");
    });
  }
  EXPECT_EQ(readFile(folder / "ok"), "x");
  try {
    files.requireWritten();
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::MatchesRegex(".*/dev/full.*; .*no/file.*"));
  }
  EXPECT_NO_THROW(OutputFiles().requireWritten());
}

}  // namespace
}  // namespace handgraft::client
