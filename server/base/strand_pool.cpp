#include "server/base/strand_pool.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::server {

StrandPool::StrandPool(std::size_t threads,
                       std::size_t most_waiting,
                       std::chrono::milliseconds patience,
                       std::size_t reserves)
    : most_waiting_(most_waiting), patience_(patience), workers_(threads) {
  HANDGRAFT_REQUIRE(threads > 0);
  threads_.reserve(threads + reserves);
  for (std::size_t i = 0; i < reserves; ++i)
    threads_.emplace_back([this] {
      runInReserve();
    });
  for (std::size_t i = 0; i < threads; ++i)
    threads_.emplace_back([this] {
      run();
    });
}

StrandPool::~StrandPool() {
  shut();
}

bool StrandPool::post(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (shut_ || tasks_.size() >= most_waiting_) return false;
    tasks_.push_back(std::move(task));
  }
  changed_.notify_one();
  reserve_.notify_one();
  return true;
}

void StrandPool::postAlways(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  changed_.notify_one();
  reserve_.notify_one();
}

void StrandPool::postIdle(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back({Clock::now(), std::move(task)});
  }
  changed_.notify_one();
  reserve_.notify_one();
}

void StrandPool::shut() {
  {
    const std::lock_guard lock(mutex_);
    shut_ = true;
  }
  changed_.notify_all();
  reserve_.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void StrandPool::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] {
      return shut_ || !tasks_.empty() || !idle_.empty();
    });
    if (tasks_.empty() && idle_.empty()) return;
    runNext(lock);
  }
}

void StrandPool::runNext(std::unique_lock<std::mutex>& lock) {
  std::function<void()> task = take();
  const auto since = at_work_since_.insert(Clock::now());
  lock.unlock();
  task();
  task = nullptr;  // what it held goes without the lock
  lock.lock();
  at_work_since_.erase(since);
}

void StrandPool::runInReserve() {
  constexpr std::chrono::milliseconds kLook(10);
  const auto nothing_waits = [this] {
    return tasks_.empty() && idle_.empty();
  };
  std::unique_lock lock(mutex_);
  while (true) {
    reserve_.wait(lock, [&] {
      return shut_ || (!nothing_waits() && !reserve_looks_);
    });
    reserve_looks_ = true;
    while (!shut_ && !nothing_waits() && !allAreLongAtWork())
      reserve_.wait_for(lock, kLook);
    reserve_looks_ = false;
    if (shut_) return;
    if (nothing_waits()) continue;
    reserve_.notify_one();
    runNext(lock);
  }
}

bool StrandPool::allAreLongAtWork() const {
  return at_work_since_.size() >= workers_ && Clock::now() - *at_work_since_.rbegin() >= kLong;
}

std::function<void()> StrandPool::take() {
  std::function<void()> task;
  const bool is_patient = idle_.empty() || Clock::now() - idle_.front().posted < patience_;
  if (!tasks_.empty() && is_patient) {
    task = std::move(tasks_.front());
    tasks_.pop_front();
  } else {
    task = std::move(idle_.front().run);
    idle_.pop_front();
  }
  return task;
}

Strand::Strand(StrandPool& pool, std::size_t most_waiting)
    : pool_(pool), most_waiting_(most_waiting), state_(std::make_shared<State>()) {}

bool Strand::post(std::function<void()> task) {
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->tasks.size() >= most_waiting_) return false;
    state_->tasks.push_back(std::move(task));
    if (state_->scheduled) return true;
    state_->scheduled = true;
  }
  if (pool_.post([&pool = pool_, state = state_] {
        runOne(pool, state);
      }))
    return true;
  // Nobody else scheduled meanwhile: `scheduled` was ours. Others may have queued behind us,
  // and would wait for ever if we only took our own task back.
  const std::lock_guard lock(state_->mutex);
  if (state_->tasks.size() == 1) {
    state_->tasks.pop_back();
    state_->scheduled = false;
    return false;
  }
  pool_.postAlways([&pool = pool_, state = state_] {
    runOne(pool, state);
  });
  return true;
}

void Strand::postFromTask(std::function<void()> task) {
  const std::lock_guard lock(state_->mutex);
  HANDGRAFT_REQUIRE(state_->scheduled);
  state_->tasks.push_back(std::move(task));
}

void Strand::postIdleFromTask(std::function<void()> task) {
  pool_.postIdle([&pool = pool_, state = state_, task = std::move(task)]() mutable {
    {
      const std::lock_guard lock(state->mutex);
      state->tasks.push_back(std::move(task));
      if (state->scheduled) return;
      state->scheduled = true;
    }
    runOne(pool, state);
  });
}

void Strand::runOne(StrandPool& pool, const std::shared_ptr<State>& state) {
  std::function<void()> task;
  {
    const std::lock_guard lock(state->mutex);
    task = std::move(state->tasks.front());
    state->tasks.pop_front();
  }
  task();
  task = nullptr;  // what it held goes before the next one begins
  const std::lock_guard lock(state->mutex);
  if (state->tasks.empty()) {
    state->scheduled = false;
    return;
  }
  // Its place is ours already: never refused, also while the pool is being shut.
  pool.postAlways([&pool, state] {
    runOne(pool, state);
  });
}

}  // namespace handgraft::server
