#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/base/error.h"

namespace handgraft::client {

/// How a call ended.
template <class T>
using Outcome = std::variant<T, std::exception_ptr>;

/// The outcome of what has nothing to tell but that it is done.
struct Done {};

using OnProgress = std::function<void(const std::string& stage, double fraction)>;

/// What a program does while it waits for an answer, on the thread that waits.
struct Waiting {
  /// Called every 50 ms. What it throws ends the wait: the call is cancelled on the server
  /// first. For Ctrl-C.
  std::function<void()> checkpoint;
  OnProgress on_progress;
};

/// An answer that is on its way. Copies stand for the same answer; when all are gone it is
/// dropped, while the work on the server goes on.
///
/// Threads: all methods from any thread, `get` not from a callback.
template <class T>
class Pending {
 public:
  /// Waits, and hands the answer out, once.
  /// Errors: those of the call; what `Waiting::checkpoint` throws.
  T get() {
    using Clock = std::chrono::steady_clock;
    std::exception_ptr stop;
    Clock::time_point patient_until = Clock::now() + kGrace;
    std::unique_lock lock(state_->mutex);
    HANDGRAFT_REQUIRE(!state_->taken);
    while (!state_->outcome) {
      state_->news.wait_for(lock, kLook);
      const auto progress = std::exchange(state_->progress, std::nullopt);
      lock.unlock();
      const Clock::time_point now = Clock::now();
      if (state_->finishes) {
        stop = reasonToStop(progress, now > patient_until);
        lock.lock();
        if (!stop || state_->outcome) continue;
        std::rethrow_exception(state_->unfinished ? state_->unfinished : stop);
      } else if (!stop) {
        stop = reasonToStop(progress, true);
        if (stop) {
          cancel();
          patient_until = now + kGrace;
        }
      } else if (now > patient_until) {
        break;
      }
      lock.lock();
    }
    if (stop && !state_->finishes) std::rethrow_exception(stop);
    state_->taken = true;
    if (auto* error = std::get_if<std::exception_ptr>(&*state_->outcome)) {
      std::rethrow_exception(*error);
    }
    return std::get<T>(std::move(*state_->outcome));
  }

  [[nodiscard]] bool ready() const { return waitFor(std::chrono::milliseconds(0)); }

  /// True once there is an outcome; waits at most so long.
  [[nodiscard]] bool waitFor(std::chrono::milliseconds timeout) const {
    std::unique_lock lock(state_->mutex);
    return state_->news.wait_for(lock, timeout, [this] {
      return state_->outcome.has_value();
    });
  }

  /// Asks the server to stop; the error is Cancelled then, unless it was done.
  void cancel() {
    std::function<void()> cancel;
    {
      const std::lock_guard lock(state_->mutex);
      cancel = state_->cancel;
    }
    if (cancel) cancel();
  }

  /// Has `use` called with the outcome, once: on the client's thread, where it must not wait
  /// for another answer, or at once if there is one already. Instead of `get`.
  void then(std::function<void(Outcome<T>)> use) {
    std::unique_lock lock(state_->mutex);
    HANDGRAFT_REQUIRE(!state_->taken && !state_->use);
    if (!state_->outcome) {
      state_->use = std::move(use);
      return;
    }
    state_->taken = true;
    lock.unlock();
    use(std::move(*state_->outcome));
  }

  // === For those who answer

  struct State {
    std::mutex mutex;
    std::condition_variable news;
    std::optional<Outcome<T>> outcome;
    std::optional<std::pair<std::string, double>> progress;
    std::function<void(Outcome<T>)> use;
    std::function<void()> cancel;
    bool taken = false;
    std::shared_ptr<const Waiting> waiting;
    /// It is not cancelled, and for so long as an answer usually takes there is no checkpoint.
    bool finishes = false;
    std::exception_ptr unfinished;  ///< thrown then; null: what the checkpoint threw

    void settle(Outcome<T> what) {
      std::unique_lock lock(mutex);
      if (outcome) return;
      cancel = nullptr;
      if (const auto tell = std::exchange(use, nullptr)) {
        taken = true;
        outcome = Outcome<T>();
        lock.unlock();
        news.notify_all();
        tell(std::move(what));
        return;
      }
      outcome = std::move(what);
      lock.unlock();
      news.notify_all();
    }

    void report(const std::string& stage, double fraction) {
      {
        const std::lock_guard lock(mutex);
        progress.emplace(stage, fraction);
      }
      news.notify_all();
    }
  };

  explicit Pending(std::shared_ptr<State> state) : state_(std::move(state)) {}

 private:
  static constexpr std::chrono::milliseconds kLook{50};
  /// For the answer to the wish to stop: a server that is silent holds nobody up.
  static constexpr std::chrono::milliseconds kGrace{2000};

  /// Why the wait is to end; nothing if it is not, or if nobody is asked.
  std::exception_ptr reasonToStop(const std::optional<std::pair<std::string, double>>& progress,
                                  bool asks) {
    if (!state_->waiting) return nullptr;
    try {
      if (progress && state_->waiting->on_progress) {
        state_->waiting->on_progress(progress->first, progress->second);
      }
      if (asks && state_->waiting->checkpoint) state_->waiting->checkpoint();
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }

  std::shared_ptr<State> state_;
};

}  // namespace handgraft::client
