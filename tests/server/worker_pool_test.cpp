#include "server/worker_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

TEST(WorkerPool, FinishesWhatItTookWhenShut) {
  std::atomic<int> done{0};
  WorkerPool pool(2, 100);
  for (int i = 0; i < 50; ++i)
    ASSERT_TRUE(pool.post([&] {
      ++done;
    }));
  pool.shut();
  EXPECT_EQ(done, 50);
  EXPECT_FALSE(pool.post([] {}));
}

TEST(WorkerPool, RefusesMoreThanMayWait) {
  std::promise<void> gate;
  std::promise<void> begun;
  WorkerPool pool(1, 1);
  ASSERT_TRUE(pool.post([&] {
    begun.set_value();
    gate.get_future().wait();
  }));
  begun.get_future().wait();
  EXPECT_TRUE(pool.post([] {}));
  EXPECT_FALSE(pool.post([] {}));
  gate.set_value();
}

TEST(Strand, RunsItsTasksInOrderOneAtATime) {
  WorkerPool pool(4, 1000);
  Strand strand(pool, 1000);
  std::vector<int> order;
  std::atomic<int> inside{0};
  bool overlapped = false;
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(strand.post([&, i] {
      overlapped = overlapped || inside++ != 0;
      order.push_back(i);
      --inside;
    }));
  }
  pool.shut();
  ASSERT_EQ(order.size(), 500u);
  EXPECT_FALSE(overlapped);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(Strand, DoesNotHoldUpAnotherOne) {
  WorkerPool pool(2, 100);
  Strand blocked(pool, 100);
  Strand other(pool, 100);
  std::promise<void> gate;
  std::promise<void> passed;
  ASSERT_TRUE(blocked.post([&] {
    gate.get_future().wait();
  }));
  ASSERT_TRUE(other.post([&] {
    passed.set_value();
  }));
  EXPECT_EQ(passed.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  gate.set_value();
}

TEST(Strand, GivesItsTaskBackWhenThePoolIsFull) {
  std::promise<void> gate;
  std::promise<void> begun;
  WorkerPool pool(1, 1);
  Strand strand(pool, 10);
  ASSERT_TRUE(pool.post([&] {
    begun.set_value();
    gate.get_future().wait();
  }));
  begun.get_future().wait();
  ASSERT_TRUE(pool.post([] {}));
  bool ran = false;
  EXPECT_FALSE(strand.post([&] {
    ran = true;
  }));
  gate.set_value();
  pool.shut();
  EXPECT_FALSE(ran);
}

}  // namespace
}  // namespace handgraft::server
