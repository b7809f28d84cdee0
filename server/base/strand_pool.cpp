#include "server/base/strand_pool.h"

#include <algorithm>
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
  return post(std::move(task), Kind::kOther);
}

bool StrandPool::post(std::function<void()> task, Kind kind) {
  {
    const std::lock_guard lock(mutex_);
    if (shut_ || short_.size() + others_.size() >= most_waiting_) return false;
    queueOf(kind).push_back(std::move(task));
  }
  wakeOne();
  return true;
}

void StrandPool::postAlways(std::function<void()> task, Kind kind) {
  {
    const std::lock_guard lock(mutex_);
    queueOf(kind).push_back(std::move(task));
  }
  wakeOne();
}

void StrandPool::postIdle(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    idle_.push_back({Clock::now(), std::move(task)});
  }
  wakeOne();
}

void StrandPool::wakeOne() {
  changed_.notify_one();
  reserve_.notify_one();
}

std::deque<std::function<void()>>& StrandPool::queueOf(Kind kind) {
  return kind == Kind::kShort ? short_ : others_;
}

bool StrandPool::nothingWaits() const {
  return short_.empty() && others_.empty() && idle_.empty();
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
      return shut_ || !nothingWaits();
    });
    if (nothingWaits()) return;
    runNext(lock);
  }
}

void StrandPool::runNext(std::unique_lock<std::mutex>& lock) {
  Next next = take();
  const Clock::time_point begin = Clock::now();
  const auto since = at_work_since_.insert(begin);
  lock.unlock();
  next.run();
  next.run = nullptr;  // what it held goes without the lock
  lock.lock();
  at_work_since_.erase(since);
  const Clock::duration took = Clock::now() - begin;
  short_ahead_ += next.kind == Kind::kShort ? took : -took;
  short_ahead_ = std::clamp<Clock::duration>(short_ahead_, -kMostAhead, kMostAhead);
}

void StrandPool::runInReserve() {
  constexpr std::chrono::milliseconds kLook(10);
  std::unique_lock lock(mutex_);
  while (true) {
    reserve_.wait(lock, [this] {
      return shut_ || (!nothingWaits() && !reserve_looks_);
    });
    reserve_looks_ = true;
    while (!shut_ && !nothingWaits() && !allAreLongAtWork())
      reserve_.wait_for(lock, kLook);
    reserve_looks_ = false;
    if (shut_) return;
    if (nothingWaits()) continue;
    reserve_.notify_one();
    runNext(lock);
  }
}

bool StrandPool::allAreLongAtWork() const {
  return at_work_since_.size() >= workers_ && Clock::now() - *at_work_since_.rbegin() >= kLong;
}

StrandPool::Next StrandPool::take() {
  const auto take_from = [](std::deque<std::function<void()>>& queue) {
    std::function<void()> task = std::move(queue.front());
    queue.pop_front();
    return task;
  };
  const bool is_idle_due = !idle_.empty() && Clock::now() - idle_.front().posted >= patience_;
  const bool others_wait = !others_.empty() || is_idle_due;
  if (!short_.empty() && (!others_wait || short_ahead_ <= Clock::duration::zero()))
    return {Kind::kShort, take_from(short_)};
  if (!others_.empty() && !is_idle_due) return {Kind::kOther, take_from(others_)};
  Next next{Kind::kOther, std::move(idle_.front().run)};
  idle_.pop_front();
  return next;
}

// === Strands

bool& Strand::State::placeOf(Kind kind) {
  return kind == Kind::kShort ? waits_as_short : waits_as_other;
}

bool Strand::State::takePlace(Kind kind) {
  return !std::exchange(placeOf(kind), true);
}

Strand::Strand(StrandPool& pool, std::size_t most_waiting)
    : pool_(pool), most_waiting_(most_waiting), state_(std::make_shared<State>()) {}

bool Strand::post(std::function<void()> task) {
  return post(std::move(task), Kind::kOther);
}

bool Strand::postShort(std::function<void()> task) {
  return post(std::move(task), Kind::kShort);
}

bool Strand::post(std::function<void()> task, Kind kind) {
  Kind turn = kind;
  std::size_t begun = 0;
  {
    const std::lock_guard lock(state_->mutex);
    std::deque<Task>& tasks = state_->tasks;
    if (tasks.size() >= most_waiting_) return false;
    const bool passes = kind == Kind::kShort && !tasks.empty() && tasks.back().lets_short_pass;
    tasks.insert(passes ? tasks.end() - 1 : tasks.end(), Task{std::move(task), kind});
    turn = tasks.front().kind;
    if (state_->is_running || !state_->takePlace(turn)) return true;
    begun = state_->begun;
  }
  if (pool_.post(turnOf(pool_, state_, turn), turn)) return true;
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->tasks.size() == 1 && state_->begun == begun) {  // ours, and nobody sees to it
      state_->tasks.pop_back();
      state_->placeOf(turn) = false;
      return false;
    }
  }
  // Others have queued behind us, and would wait for ever if we only took our own task back.
  pool_.postAlways(turnOf(pool_, state_, turn), turn);
  return true;
}

void Strand::append(Task task) {
  const std::lock_guard lock(state_->mutex);
  HANDGRAFT_REQUIRE(state_->is_running);
  state_->tasks.push_back(std::move(task));
}

void Strand::postFromTask(std::function<void()> task) {
  append({std::move(task)});
}

void Strand::postBehindShortFromTask(std::function<void()> task) {
  append({std::move(task), Kind::kOther, true});
}

void Strand::postIdleFromTask(std::function<void()> task) {
  pool_.postIdle([&pool = pool_, state = state_, task = std::move(task)]() mutable {
    {
      const std::lock_guard lock(state->mutex);
      state->tasks.push_back({std::move(task)});
      if (state->is_running || state->waits_as_short || !state->takePlace(Kind::kOther)) return;
    }
    runTurn(pool, state, Kind::kOther);
  });
}

std::function<void()> Strand::turnOf(StrandPool& pool,
                                     const std::shared_ptr<State>& state,
                                     Kind kind) {
  return [&pool, state, kind] {
    runTurn(pool, state, kind);
  };
}

void Strand::runTurn(StrandPool& pool, const std::shared_ptr<State>& state, Kind kind) {
  std::unique_lock lock(state->mutex);
  state->placeOf(kind) = false;
  if (state->is_running) return;  // who runs it sees to what it leaves
  state->is_running = true;
  const auto end = StrandPool::Clock::now() + kTurn;
  bool may_go_on = true;
  while (may_go_on && !state->tasks.empty()) {
    const bool is_short = state->tasks.front().kind == Kind::kShort;
    if (!is_short && kind == Kind::kShort) break;
    Task task = std::move(state->tasks.front());
    state->tasks.pop_front();
    ++state->begun;
    lock.unlock();
    task.run();
    task.run = nullptr;  // what it held goes before the next one begins
    may_go_on = is_short && StrandPool::Clock::now() < end;
    lock.lock();
  }
  state->is_running = false;
  if (state->tasks.empty()) return;
  const Kind next = state->tasks.front().kind;
  if (!state->takePlace(next)) return;
  lock.unlock();
  // It was taken once: never refused now, also while the pool is being shut.
  pool.postAlways(turnOf(pool, state, next), next);
}

}  // namespace handgraft::server
