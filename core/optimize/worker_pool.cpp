#include "core/optimize/worker_pool.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::optimize {

WorkerPool::WorkerPool(int workers) : workers_(workers) {
  HANDGRAFT_REQUIRE(workers >= 1);
}

WorkerPool::~WorkerPool() {
  for (std::jthread& thread : threads_)
    thread.request_stop();
}

void WorkerPool::run(int count, const Task& task) {
  const bool alone = workers_ == 1 || count <= 1;
  {
    const std::lock_guard lock(mutex_);
    next_ = 0;
    failed_ = false;
    error_ = nullptr;
    count_ = count;
    task_ = &task;
    if (!alone) {
      for (int i = static_cast<int>(threads_.size()) + 1; i < workers_; ++i) {
        threads_.emplace_back([this, i](const std::stop_token& stop) {
          serve(stop, i);
        });
      }
      ++generation_;
      busy_ = static_cast<int>(threads_.size());
    }
  }
  if (!alone) wake_.notify_all();
  work(0);
  {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] {
      return busy_ == 0;
    });
    task_ = nullptr;
  }
  if (error_ != nullptr) std::rethrow_exception(std::exchange(error_, nullptr));
}

void WorkerPool::work(int worker) {
  try {
    for (int i = next_++; i < count_ && !failed(); i = next_++)
      (*task_)(worker, i);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    // The first failure counts; the others stop because of it.
    if (!failed_.exchange(true)) error_ = std::current_exception();
  }
}

void WorkerPool::serve(const std::stop_token& stop, int worker) {
  long long seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      const bool more = wake_.wait(lock, stop, [&] {
        return generation_ != seen;
      });
      if (!more) return;
      seen = generation_;
    }
    work(worker);
    const std::lock_guard lock(mutex_);
    if (--busy_ == 0) done_.notify_all();
  }
}

}  // namespace handgraft::optimize
