#include "core/base/background_task.h"

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace handgraft {
namespace {

/// Until somebody calls it off.
int forEver(const Progress& progress) {
  for (;;)
    progress.checkpoint();
}

TEST(BackgroundTask, GivesWhatItsWorkGave) {
  BackgroundTask<std::string> task([](const Progress&) {
    return std::string("done");
  });
  EXPECT_EQ(task.get(Progress()), "done");
}

TEST(BackgroundTask, WorksBesideItsOwner) {
  const std::thread::id here = std::this_thread::get_id();
  BackgroundTask<bool> task([here](const Progress&) {
    return std::this_thread::get_id() != here;
  });
  EXPECT_TRUE(task.get(Progress()));
}

TEST(BackgroundTask, ThrowsWhatItsWorkThrew) {
  BackgroundTask<int> task([](const Progress&) -> int {
    throw std::runtime_error("broken");
  });
  EXPECT_THROW((void)task.get(Progress()), std::runtime_error);
}

TEST(BackgroundTask, IsCalledOffWhereItIsDropped) {
  std::atomic<bool> ended{false};
  {
    const BackgroundTask<int> task([&ended](const Progress& progress) {
      try {
        return forEver(progress);
      } catch (const Cancelled&) {
        ended = true;
        throw;
      }
    });
  }
  EXPECT_TRUE(ended) << "nothing of it is left";
}

TEST(BackgroundTask, WhoIsToStopDoesNotWaitForIt) {
  BackgroundTask<int> task(forEver);
  Progress waiting;
  waiting.cancel();
  EXPECT_THROW((void)task.get(waiting), Cancelled);
}

}  // namespace
}  // namespace handgraft
