#include "core/base/scratch_folder.h"

#include <chrono>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace handgraft {
namespace {

namespace fs = std::filesystem;

void makeOld(const fs::path& folder) {
  fs::last_write_time(folder, fs::file_time_type::clock::now() - std::chrono::hours(1));
}

TEST(ScratchFolder, GoesWithItsOwner) {
  fs::path path;
  {
    const ScratchFolder folder("handgraft-scratch-test");
    path = folder.path();
    std::ofstream(path / "file") << "text";
    EXPECT_EQ(fs::status(path).permissions() & fs::perms::all, fs::perms::owner_all);
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(ScratchFolder, IsRemovedByTheNextWhereItsProcessWasKilled) {
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  if (child == 0) {
    const ScratchFolder left("handgraft-scratch-test");
    std::ofstream(left.path() / "file") << "text";
    const std::string path = left.path().string();
    _exit(write(told[1], path.data(), path.size()) > 0 ? 0 : 1);  // nothing is tidied up
  }
  std::string text(4096, '\0');
  const ssize_t size = read(told[0], text.data(), text.size());
  ASSERT_GT(size, 0);
  text.resize(static_cast<std::size_t>(size));
  waitpid(child, nullptr, 0);
  const fs::path left = text;
  ASSERT_TRUE(fs::exists(left / "file"));
  { const ScratchFolder other("handgraft-scratch-test"); }
  EXPECT_TRUE(fs::exists(left)) << "one that is that young may not be locked yet";
  makeOld(left);
  { const ScratchFolder other("handgraft-scratch-other"); }
  EXPECT_TRUE(fs::exists(left)) << "it is of another kind";
  const ScratchFolder lives("handgraft-scratch-test");
  EXPECT_FALSE(fs::exists(left));
  makeOld(lives.path());
  const ScratchFolder next("handgraft-scratch-test");
  EXPECT_TRUE(fs::exists(lives.path())) << "its owner lives";
}

}  // namespace
}  // namespace handgraft
