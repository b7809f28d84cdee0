#include "server/base/strand_pool.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

TEST(StrandPool, FinishesWhatItTookWhenShut) {
  std::atomic<int> done{0};
  StrandPool pool(2, 100);
  for (int i = 0; i < 50; ++i)
    ASSERT_TRUE(pool.post([&] {
      ++done;
    }));
  pool.shut();
  EXPECT_EQ(done, 50);
  EXPECT_FALSE(pool.post([] {}));
}

TEST(StrandPool, LongTasksHoldNobodyUpWhileThereAreReserves) {
  std::promise<void> gate;
  const std::shared_future<void> open = gate.get_future().share();
  StrandPool pool(2, 100, StrandPool::kPatience, 4);
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(pool.post([open] {
      open.wait();
    }));
  std::promise<void> done;
  ASSERT_TRUE(pool.post([&] {
    done.set_value();
  }));
  EXPECT_EQ(done.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  gate.set_value();
}

TEST(StrandPool, LongTasksHoldIdleOnesUpNoMore) {
  std::promise<void> gate;
  const std::shared_future<void> open = gate.get_future().share();
  StrandPool pool(1, 100, std::chrono::hours(1), 2);
  Strand strand(pool, 8);
  std::promise<void> done;
  ASSERT_TRUE(strand.post([&] {
    ASSERT_TRUE(pool.post([open] {
      open.wait();
    }));
    strand.postIdleFromTask([&] {
      done.set_value();
    });
  }));
  EXPECT_EQ(done.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  gate.set_value();
}

TEST(StrandPool, LeavesShortTasksToItsWorkers) {
  std::mutex mutex;
  std::set<std::thread::id> seen;
  {
    StrandPool pool(2, 10'000, StrandPool::kPatience, 4);
    for (int i = 0; i < 2000; ++i)
      ASSERT_TRUE(pool.post([&] {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        const std::lock_guard lock(mutex);
        seen.insert(std::this_thread::get_id());
      }));
  }
  EXPECT_LE(seen.size(), 2u);
}

TEST(StrandPool, RefusesMoreThanMayWait) {
  std::promise<void> gate;
  std::promise<void> begun;
  StrandPool pool(1, 1);
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
  StrandPool pool(4, 1000);
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
  StrandPool pool(2, 100);
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
  StrandPool pool(1, 1);
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

// === Short tasks

/// A pool of one worker that is at work until it is told to go on.
struct BusyPool {
  explicit BusyPool(std::size_t most_waiting = 1000) : pool(1, most_waiting) {
    std::promise<void> begun;
    EXPECT_TRUE(pool.post([&, open = gate.get_future().share()] {
      begun.set_value();
      open.wait();
    }));
    begun.get_future().wait();
  }

  ~BusyPool() { goOn(); }

  BusyPool(const BusyPool&) = delete;
  BusyPool& operator=(const BusyPool&) = delete;

  void open() {
    if (std::exchange(is_busy, false)) gate.set_value();
  }

  /// Until all is done.
  void goOn() {
    open();
    pool.shut();
  }

  bool is_busy = true;
  std::promise<void> gate;
  std::vector<std::string> order;
  StrandPool pool;

  std::function<void()> write(const std::string& what) {
    return [this, what] {
      order.push_back(what);
    };
  }
};

TEST(ShortTasks, RunBeforeOtherStrandsLongerOnes) {
  BusyPool busy;
  Strand solving(busy.pool, 10);
  Strand edited(busy.pool, 10);
  ASSERT_TRUE(solving.post(busy.write("solve")));
  ASSERT_TRUE(edited.postShort(busy.write("edit")));
  busy.goOn();
  EXPECT_THAT(busy.order, testing::ElementsAre("edit", "solve"));
}

TEST(ShortTasks, ShareATurnSoThatManyDoNotWaitForAsManyTurnsOfAll) {
  BusyPool busy;
  Strand other(busy.pool, 100);
  Strand edited(busy.pool, 100);
  ASSERT_TRUE(edited.postShort(busy.write("a")));
  ASSERT_TRUE(other.postShort(busy.write("other")));
  ASSERT_TRUE(edited.postShort(busy.write("b")));
  ASSERT_TRUE(edited.post(busy.write("request")));
  busy.goOn();
  EXPECT_THAT(busy.order, testing::ElementsAre("a", "b", "other", "request"));
}

TEST(ShortTasks, PassTheirStrandsLastTaskWhereThatLetsThem) {
  BusyPool busy;
  Strand strand(busy.pool, 100);
  ASSERT_TRUE(strand.postShort([&] {
    busy.order.push_back("edit 1");
    strand.postBehindShortFromTask(busy.write("solve 1 and 2"));
    ASSERT_TRUE(strand.postShort(busy.write("edit 2")));
    ASSERT_TRUE(strand.post([&] {
      busy.order.push_back("request");
      strand.postFromTask(busy.write("what it left"));
      ASSERT_TRUE(strand.postShort(busy.write("edit 4")));
    }));
    ASSERT_TRUE(strand.postShort(busy.write("edit 3")));
  }));
  busy.goOn();
  EXPECT_THAT(busy.order, testing::ElementsAre("edit 1", "edit 2", "solve 1 and 2", "request",
                                               "edit 3", "what it left", "edit 4"));
}

TEST(ShortTasks, PassALastTaskThatWaitsForItsTurnAlready) {
  BusyPool busy;
  Strand solving(busy.pool, 10);
  Strand edited(busy.pool, 10);
  ASSERT_TRUE(edited.postShort([&] {
    edited.postBehindShortFromTask(busy.write("solve"));
  }));
  ASSERT_TRUE(solving.post([&] {  // before that solve has its turn
    ASSERT_TRUE(edited.postShort(busy.write("edit")));
  }));
  busy.goOn();
  EXPECT_THAT(busy.order, testing::ElementsAre("edit", "solve"));
}

TEST(ShortTasks, LeaveOthersHalfOfTheTime) {
  BusyPool busy;
  std::vector<std::unique_ptr<Strand>> edited;
  const auto spend = [] {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  constexpr int kShort = 60;
  for (int i = 0; i < kShort; ++i) {
    edited.push_back(std::make_unique<Strand>(busy.pool, 10));
    ASSERT_TRUE(edited.back()->postShort([&, spend] {
      spend();
      busy.order.push_back("edit");
    }));
  }
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(busy.pool.post([&, spend] {
      spend();
      busy.order.push_back("solve");
    }));
  busy.goOn();
  // 600 ms of edits, of which 200 at most come before the solves have as much.
  const auto last_solve = std::find(busy.order.rbegin(), busy.order.rend(), "solve");
  EXPECT_GT(std::count(busy.order.rbegin(), last_solve, "edit"), kShort / 4);
}

TEST(ShortTasks, AreGivenBackOnlyWhereNobodyElseSeesToThem) {
  BusyPool busy(2);
  Strand strand(busy.pool, 10);
  bool is_refused = false;
  std::promise<void> posted;
  ASSERT_TRUE(strand.post([&] {
    strand.postBehindShortFromTask(busy.write("solve"));
  }));
  ASSERT_TRUE(busy.pool.post([&] {  // the solve waits already, as this does no more
    ASSERT_TRUE(busy.pool.post([] {}));
    EXPECT_TRUE(strand.postShort(busy.write("edit")));  // no place of its own is left
    Strand other(busy.pool, 10);
    is_refused = !other.postShort(busy.write("nobody's"));
    posted.set_value();
  }));
  busy.open();
  posted.get_future().wait();
  busy.goOn();
  EXPECT_TRUE(is_refused);
  EXPECT_THAT(busy.order, testing::ElementsAre("edit", "solve"));
}

TEST(ShortTasks, NeverOverlapWithTheirStrandAndAllRun) {
  StrandPool pool(4, 100'000, std::chrono::milliseconds(1));
  Strand strand(pool, 100'000);
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};
  std::atomic<int> done{0};
  const auto work = [&] {
    if (inside++ != 0) overlapped = true;
    ++done;
    --inside;
  };
  constexpr int kRounds = 2000;
  for (int i = 0; i < kRounds; ++i) {
    ASSERT_TRUE(strand.postShort([&, work] {
      work();
      strand.postBehindShortFromTask([&, work] {
        work();
        strand.postIdleFromTask(work);
      });
    }));
    ASSERT_TRUE(strand.post(work));
  }
  pool.shut();
  EXPECT_FALSE(overlapped);
  EXPECT_EQ(done, 4 * kRounds);
}

// === Idle tasks

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): of durations

constexpr auto kForEver = 10min;

/// One worker that waits until `open`, while tasks are given.
struct Gate {
  void closeOn(StrandPool& pool) {
    std::promise<void> begun;
    ASSERT_TRUE(pool.post([&] {
      begun.set_value();
      promise.get_future().wait();
    }));
    begun.get_future().wait();
  }

  void open() { promise.set_value(); }

  std::promise<void> promise;
};

TEST(IdleTasks, RunAfterAllOthersAlsoOfOtherStrands) {
  StrandPool pool(1, 100, kForEver);
  Strand first(pool, 100);
  Strand second(pool, 100);
  std::vector<int> order;
  Gate gate;
  gate.closeOn(pool);
  const auto note = [&](int number) {
    return [&order, number] {
      order.push_back(number);
    };
  };
  ASSERT_TRUE(first.post([&] {
    first.postIdleFromTask(note(4));
    first.postFromTask(note(3));
  }));
  ASSERT_TRUE(second.post(note(1)));
  ASSERT_TRUE(pool.post(note(2)));
  gate.open();
  pool.shut();
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4}));
}

TEST(IdleTasks, RunNextOnceTheyWaitedTooLong) {
  StrandPool pool(1, 100, 0ms);
  Strand strand(pool, 100);
  std::vector<int> order;
  Gate gate;
  gate.closeOn(pool);
  ASSERT_TRUE(strand.post([&] {
    strand.postIdleFromTask([&] {
      order.push_back(1);
    });
  }));
  for (int i = 2; i < 5; ++i) {
    ASSERT_TRUE(pool.post([&order, i] {
      order.push_back(i);
    }));
  }
  gate.open();
  pool.shut();
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4}));
}

TEST(IdleTasks, AreNotStarvedByAPoolThatAlwaysHasWork) {
  StrandPool pool(2, 100, 20ms);
  Strand strand(pool, 100);
  std::atomic<bool> is_over{false};
  std::promise<void> done;
  // Four tasks that follow themselves keep two workers busy.
  std::function<void()> again = [&] {
    if (!is_over) static_cast<void>(pool.post(again));
  };
  for (int i = 0; i < 4; ++i)
    ASSERT_TRUE(pool.post(again));
  ASSERT_TRUE(strand.post([&] {
    strand.postIdleFromTask([&] {
      done.set_value();
    });
  }));
  EXPECT_EQ(done.get_future().wait_for(60s), std::future_status::ready);
  is_over = true;
  pool.shut();
}

TEST(IdleTasks, NeverOverlapWithTheirStrandAndAllRun) {
  constexpr int kRounds = 2000;
  StrandPool pool(4, 100'000, 1ms);
  std::array<Strand, 3> strands{Strand(pool, 10'000), Strand(pool, 10'000),
                                Strand(pool, 10'000)};
  std::array<std::atomic<int>, 3> inside{};
  std::array<int, 3> done{};  // of one strand's tasks alone, unguarded on purpose
  std::atomic<bool> overlapped{false};
  const auto work = [&](std::size_t at) {
    if (inside[at]++ != 0) overlapped = true;
    ++done[at];
    --inside[at];
  };
  for (int i = 0; i < kRounds; ++i) {
    for (std::size_t at = 0; at < strands.size(); ++at) {
      ASSERT_TRUE(strands[at].post([&, at] {
        work(at);
        strands[at].postIdleFromTask([&, at] {
          work(at);
        });
      }));
    }
  }
  pool.shut();
  EXPECT_FALSE(overlapped);
  for (const int count : done)
    EXPECT_EQ(count, 2 * kRounds);
}

TEST(IdleTasks, RunBehindWhatTheirStrandHasToDoByThen) {
  StrandPool pool(2, 100, kForEver);
  Strand strand(pool, 100);
  std::vector<int> order;
  std::promise<void> passed;
  ASSERT_TRUE(strand.post([&] {
    strand.postFromTask([&] {
      order.push_back(1);
    });
    strand.postIdleFromTask([&] {  // the other worker is free to take it, at once
      order.push_back(2);
    });
    passed.get_future().wait();
    order.push_back(0);
  }));
  ASSERT_TRUE(pool.post([&] {
    passed.set_value();
  }));
  pool.shut();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

TEST(IdleTasks, ThatWaitWhenThePoolIsShutStillRunAndWhatTheyPostDoes) {
  std::atomic<int> done{0};
  StrandPool pool(1, 100, kForEver);
  Gate gate;
  gate.closeOn(pool);
  auto strand = std::make_unique<Strand>(pool, 100);
  ASSERT_TRUE(strand->post([&done, copy = *strand]() mutable {
    for (int i = 0; i < 5; ++i) {
      copy.postIdleFromTask([&done, copy]() mutable {
        ++done;
        copy.postIdleFromTask([&done] {
          ++done;
        });
      });
    }
  }));
  strand.reset();
  std::thread shutting([&] {
    pool.shut();
  });
  gate.open();
  shutting.join();
  EXPECT_EQ(done, 10);
}

}  // namespace
}  // namespace handgraft::server
