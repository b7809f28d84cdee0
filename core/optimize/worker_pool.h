#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace handgraft::optimize {

/// Threads that wait for work, so that a solve of a millisecond does not pay for making them.
class WorkerPool {
 public:
  /// The caller works, too: `workers` - 1 threads are made, at the first `run` of more than one
  /// task.
  explicit WorkerPool(int workers);
  ~WorkerPool();

  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Which worker works, 0 to workers - 1, and on which task.
  using Task = std::function<void(int worker, int index)>;

  /// Calls `task` once for every index in [0, count), in any order, and returns when all are
  /// done. The first exception ends the run (tasks under way still end) and is thrown from
  /// here. One run at a time.
  void run(int count, const Task& task);

  [[nodiscard]] int workers() const { return workers_; }

  /// Some task of the run under way has thrown: the others need not go on.
  [[nodiscard]] bool failed() const { return failed_.load(std::memory_order_relaxed); }

 private:
  void work(int worker);
  void serve(const std::stop_token& stop, int worker);

  const int workers_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::condition_variable_any done_;
  long long generation_ = 0;
  int busy_ = 0;
  int count_ = 0;
  const Task* task_ = nullptr;
  std::atomic<int> next_{0};
  std::atomic<bool> failed_{false};
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;  ///< last: they end before what they use
};

}  // namespace handgraft::optimize
