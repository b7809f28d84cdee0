#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <utility>

#include "core/base/progress.h"

namespace handgraft {

/// Long work on a thread of its own, beside that of its owner. Dropped, it is called off and
/// waited for. Used by one thread.
template <typename Result>
class BackgroundTask {
 public:
  using Work = std::function<Result(const Progress&)>;

  /// `work` must not look at what its owner changes meanwhile.
  explicit BackgroundTask(Work work)
      : result_(std::async(std::launch::async, [this, does = std::move(work)] {
          return does(progress_);
        })) {}

  BackgroundTask(const BackgroundTask&) = delete;  // its thread refers to it
  BackgroundTask& operator=(const BackgroundTask&) = delete;

  ~BackgroundTask() { progress_.cancel(); }

  /// Waits for it; once. Errors: what the work threw; Cancelled if who waits is to stop.
  Result get(const Progress& waiting) {
    constexpr std::chrono::milliseconds kLook(2);
    while (result_.wait_for(kLook) != std::future_status::ready)
      waiting.checkpoint();
    return result_.get();
  }

 private:
  Progress progress_;
  std::future<Result> result_;  ///< last: waits for the thread, which uses the rest
};

}  // namespace handgraft
