#include "core/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace handgraft {

namespace {

constexpr int kMostUnasked = 4;

}  // namespace

void parallelFor(int count, const std::function<void(int)>& work, int threads) {
  std::atomic<int> next = 0;
  std::mutex mutex;
  int failed = count;  // the lowest that did
  std::exception_ptr error;
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) {
      {
        const std::lock_guard lock(mutex);
        if (i > failed) return;
      }
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i >= failed) continue;
        failed = i;
        error = std::current_exception();
      }
    }
  };
  {
    if (threads == 0)
      threads = std::min(static_cast<int>(std::thread::hardware_concurrency()), kMostUnasked);
    std::vector<std::jthread> others;
    for (int k = 1; k < std::min(count, threads); ++k)
      others.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace handgraft
