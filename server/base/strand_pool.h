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

/// A number of threads that run tasks: short ones first, but for no more than half of the time
/// where others wait; the rest in the order given; and idle ones of strands when nothing else
/// waits. Tasks must not throw.
///
/// Where all of them have been at one task for `kLong` and others wait, reserves take those,
/// one each: long solves hold nobody's edit up.
class StrandPool {
 public:
  static constexpr std::chrono::milliseconds kPatience{250};
  static constexpr std::chrono::milliseconds kLong{100};

  /// `most_waiting` tasks may queue. An idle task that has waited for `patience` comes before
  /// all but short ones.
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

  enum class Kind { kShort, kOther };

  /// What short tasks may have of the time beyond their half, and others likewise.
  static constexpr std::chrono::milliseconds kMostAhead{100};

  struct IdleTask {
    Clock::time_point posted;
    std::function<void()> run;
  };

  struct Next {
    Kind kind = Kind::kOther;
    std::function<void()> run;
  };

  [[nodiscard]] bool post(std::function<void()> task, Kind kind);
  void postAlways(std::function<void()> task, Kind kind);
  void postIdle(std::function<void()> task);
  void wakeOne();
  void run();
  void runInReserve();
  /// Runs the next one with the lock given back meanwhile.
  void runNext(std::unique_lock<std::mutex>& lock);
  // With `mutex_` held:
  [[nodiscard]] std::deque<std::function<void()>>& queueOf(Kind kind);
  [[nodiscard]] bool nothingWaits() const;
  /// Every thread that is not in reserve has been at its task for long.
  [[nodiscard]] bool allAreLongAtWork() const;
  /// The next one, of those that wait.
  Next take();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> short_;
  std::deque<std::function<void()>> others_;
  std::deque<IdleTask> idle_;  ///< the longest waiting one first
  /// By how much short tasks took more time than all others, `kMostAhead` at most.
  Clock::duration short_ahead_{0};
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
/// A strand takes a place or two in the pool however many tasks it holds. Its short tasks that
/// follow one another share a turn, so that one with many does not wait for as many turns of
/// all; it gives way to other strands after that and after each other task. It may be dropped
/// while tasks wait; they still run.
class Strand {
 public:
  /// Of short ones after one another, before others have their turn.
  static constexpr std::chrono::milliseconds kTurn{5};

  Strand(StrandPool& pool, std::size_t most_waiting);

  /// False, and the task is not taken, when too many wait or the pool refuses.
  [[nodiscard]] bool post(std::function<void()> task);

  /// Likewise, of what takes little time and somebody waits for.
  [[nodiscard]] bool postShort(std::function<void()> task);

  /// Takes one more task than may wait. Of a task of this strand alone: its place in the pool
  /// is ours already.
  void postFromTask(std::function<void()> task);

  /// Likewise, and as long as it is the last one, short ones that come run before it.
  void postBehindShortFromTask(std::function<void()> task);

  /// As `postFromTask`, and the task comes when nothing waits in the pool or it has waited for
  /// the pool's patience, behind what the strand has to do by then.
  void postIdleFromTask(std::function<void()> task);

 private:
  using Kind = StrandPool::Kind;

  struct Task {
    std::function<void()> run;
    Kind kind = Kind::kOther;
    bool lets_short_pass = false;
  };

  struct State {
    std::mutex mutex;
    std::deque<Task> tasks;
    std::size_t begun = 0;  ///< tasks
    bool is_running = false;
    // Its places in the pool's two queues.
    bool waits_as_short = false;
    bool waits_as_other = false;

    bool& placeOf(Kind kind);
    /// True if that place was free, and is taken now; `mutex` held.
    bool takePlace(Kind kind);
  };

  [[nodiscard]] bool post(std::function<void()> task, Kind kind);
  void append(Task task);
  /// Its turn in one of the pool's queues.
  static void runTurn(StrandPool& pool, const std::shared_ptr<State>& state, Kind kind);
  static std::function<void()> turnOf(StrandPool& pool,
                                      const std::shared_ptr<State>& state,
                                      Kind kind);

  StrandPool& pool_;
  std::size_t most_waiting_;
  std::shared_ptr<State> state_;
};

}  // namespace handgraft::server
