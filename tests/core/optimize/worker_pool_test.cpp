#include "core/optimize/worker_pool.h"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

namespace handgraft::optimize {
namespace {

TEST(WorkerPool, DoesEveryTaskOnceInEveryRun) {
  for (const int workers : {1, 2, 5}) {
    WorkerPool pool(workers);
    for (const int count : {0, 1, 2, 100, 3}) {
      std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
      pool.run(count, [&](int worker, int index) {
        EXPECT_GE(worker, 0);
        EXPECT_LT(worker, workers);
        ++done[static_cast<std::size_t>(index)];
      });
      EXPECT_TRUE(std::all_of(done.begin(), done.end(), [](const std::atomic<int>& n) {
        return n == 1;
      }));
    }
  }
}

TEST(WorkerPool, GivesAWorkerOneTaskAtATime) {
  WorkerPool pool(4);
  std::vector<std::atomic<int>> under_way(4);
  pool.run(200, [&](int worker, int) {
    EXPECT_EQ(under_way[static_cast<std::size_t>(worker)]++, 0);
    std::this_thread::yield();
    --under_way[static_cast<std::size_t>(worker)];
  });
}

TEST(WorkerPool, ThrowsWhatATaskThrewAndWorksOn) {
  WorkerPool pool(3);
  std::atomic<int> begun{0};
  EXPECT_THROW(pool.run(100000,
                        [&](int, int index) {
                          ++begun;
                          if (index >= 5) throw std::out_of_range("a task");
                        }),
               std::out_of_range);
  EXPECT_LE(begun, 5 + 3) << "each worker ends with the first that throws";
  begun = 0;
  pool.run(10, [&](int, int) {
    ++begun;
  });
  EXPECT_EQ(begun, 10);
}

}  // namespace
}  // namespace handgraft::optimize
