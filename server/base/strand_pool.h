#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace handgraft::server {

/// A number of threads that run tasks in the order given, and idle ones of strands when nothing
/// else waits. Tasks must not throw.
///
/// Where all of them have been at one task for `kLong` and others wait, reserves take those,
/// one each: long solves hold nobody's edit up.
class StrandPool {
 public:
  static constexpr std::chrono::milliseconds kPatience{250};
  static constexpr std::chrono::milliseconds kLong{100};

  /// `most_waiting` tasks may queue. An idle task that has waited for `patience` is next.
  StrandPool(std::size_t threads,
             std::size_t most_waiting,
             std::chrono::milliseconds patience = kPatience,
             std::size_t reserves = 0);
  /// Finishes what runs and what waits.
  ~StrandPool();
  StrandPool(const StrandPool&) = delete;
  StrandPool& operator=(const StrandPool&) = delete;

  /// False, and the task is not taken, when too many wait or the pool is being shut.
  [[nodiscard]] bool post(std::function<void()> task);

  /// Takes no more tasks, finishes those it has, and joins the threads. Not from a task.
  void shut();

 private:
  friend class Strand;
  using Clock = std::chrono::steady_clock;

  struct IdleTask {
    Clock::time_point posted;
    std::function<void()> run;
  };

  void postAlways(std::function<void()> task);
  void postIdle(std::function<void()> task);
  void run();
  void runInReserve();
  /// Runs the next one with the lock given back meanwhile.
  void runNext(std::unique_lock<std::mutex>& lock);
  /// Every thread that is not in reserve has been at its task for long; `mutex_` held.
  [[nodiscard]] bool allAreLongAtWork() const;
  /// The next one, of those that wait; `mutex_` held.
  std::function<void()> take();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  std::deque<IdleTask> idle_;  ///< the longest waiting one first
  std::size_t most_waiting_;
  std::chrono::milliseconds patience_;
  bool shut_ = false;
  const std::size_t workers_;
  std::condition_variable reserve_;
  bool reserve_looks_ = false;                      ///< one of them at a time
  std::multiset<Clock::time_point> at_work_since_;  ///< all threads', reserves among them
  std::vector<std::thread> threads_;
};

/// Tasks that run one after another, in order, on whichever worker is free: one session's work.
///
/// A strand takes one place in the pool however many tasks it holds, and gives way to other
/// strands after each of them. It may be dropped while tasks wait; they still run.
class Strand {
 public:
  Strand(StrandPool& pool, std::size_t most_waiting);

  /// False, and the task is not taken, when too many wait or the pool refuses.
  [[nodiscard]] bool post(std::function<void()> task);

  /// Takes one more task than may wait. Of a task of this strand alone: its place in the pool
  /// is ours already.
  void postFromTask(std::function<void()> task);

  /// Likewise, and the task comes when nothing waits in the pool or it has waited for the
  /// pool's patience, behind what the strand has to do by then.
  void postIdleFromTask(std::function<void()> task);

 private:
  struct State {
    std::mutex mutex;
    std::deque<std::function<void()>> tasks;
    bool scheduled = false;
  };

  static void runOne(StrandPool& pool, const std::shared_ptr<State>& state);

  StrandPool& pool_;
  std::size_t most_waiting_;
  std::shared_ptr<State> state_;
};

}  // namespace handgraft::server
