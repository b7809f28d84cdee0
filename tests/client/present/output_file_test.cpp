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
    folder_ = test::scratchDirectory() / ("output" + std::to_string(++count));
    fs::create_directories(folder_);
  }

  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  static std::string objectionTo(const fs::path& path) {
    try {
      requireWritable({"--out", path});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(OutputFile, ReplacesAFileAndKeepsItsPermissions) {
  const fs::path file = folder_ / "a.json";
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
  const fs::path pipe = folder_ / "pipe";
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
  fs::create_directories(folder_ / "far");
  writeFile(folder_ / "far" / "old", "old");
  fs::create_symlink("far/old", folder_ / "to_old");
  fs::create_symlink("far/new", folder_ / "to_new");
  fs::create_symlink("to_new", folder_ / "twice");
  writeFile(folder_ / "to_old", "1");
  writeFile(folder_ / "twice", "2");
  EXPECT_TRUE(fs::is_symlink(folder_ / "to_old"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "to_new"));
  EXPECT_EQ(readFile(folder_ / "far" / "old"), "1");
  EXPECT_EQ(readFile(folder_ / "far" / "new"), "2");
}

TEST_F(OutputFile, RefusesWhatCannotBeWritten) {
  const fs::path file = folder_ / "mine.json";
  writeFile(file, "mine");
  fs::permissions(file, fs::perms::owner_read);
  EXPECT_THAT(objectionTo(file), HasSubstr("mine.json"));
  EXPECT_THROW(writeFile(file, "yours"), InvalidInput);
  EXPECT_EQ(readFile(file), "mine");
  EXPECT_THAT(objectionTo(""), HasSubstr("--out ''"));
  EXPECT_THAT(objectionTo(folder_), HasSubstr("folder"));
  EXPECT_THAT(objectionTo(folder_ / "no" / "a"), HasSubstr("no folder"));
  EXPECT_THAT(objectionTo(file / "a"), HasSubstr("--out"));
  fs::create_symlink("loop", folder_ / "loop");
  EXPECT_THAT(objectionTo(folder_ / "loop"), HasSubstr("loop"));
  EXPECT_EQ(objectionTo(folder_ / "new.json"), "");
  EXPECT_EQ(entries(), 2U);  // checks write nothing
}

TEST_F(OutputFile, KnowsOneFileByTwoNames) {
  fs::create_symlink("new", folder_ / "link");
  const auto same = [&](const fs::path& a, const fs::path& b) {
    try {
      requireDistinct({{"--out", a}, {"--png", b}});
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("--out and --png"));
      return true;
    }
    return false;
  };
  EXPECT_TRUE(same(folder_ / "new", folder_ / "." / "new"));
  EXPECT_TRUE(same(folder_ / "link", folder_ / "new"));
  EXPECT_TRUE(same("relative", fs::absolute("relative")));
  EXPECT_FALSE(same(folder_ / "new", folder_ / "newer"));
  writeFile(folder_ / "new", "x");
  fs::create_hard_link(folder_ / "new", folder_ / "hard");
  EXPECT_TRUE(same(folder_ / "hard", folder_ / "link"));
}

TEST_F(OutputFile, KeepsNoOtherFromBeingWritten) {
  OutputFiles files;
  for (const fs::path& path :
       {fs::path("/dev/full"), folder_ / "ok", folder_ / "no" / "file"}) {
    files.write([&] {
      writeFile(path, "x");
    });
  }
  EXPECT_EQ(readFile(folder_ / "ok"), "x");
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
