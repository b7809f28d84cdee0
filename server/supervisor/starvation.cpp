#include "server/supervisor/starvation.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace handgraft::server {

std::chrono::nanoseconds Starvation::sinceLast() {
  namespace fs = std::filesystem;
  std::map<std::string, std::int64_t> now;
  std::int64_t most = 0;
  std::error_code error;
  const fs::path threads = fs::path("/proc") / std::to_string(process_) / "task";
  for (auto at = fs::directory_iterator(threads, error);
       !error && at != fs::directory_iterator(); at.increment(error)) {
    // Documentation/scheduler/sched-stats: time on a processor, time waiting for one, turns.
    std::ifstream file(at->path() / "schedstat");
    std::int64_t ran_ns = 0;
    std::int64_t waited_ns = 0;
    if (!(file >> ran_ns >> waited_ns)) continue;
    const std::string thread = at->path().filename().string();
    now[thread] = waited_ns;
    const auto before = waited_ns_.find(thread);
    if (before != waited_ns_.end()) most = std::max(most, waited_ns - before->second);
  }
  waited_ns_ = std::move(now);
  return std::chrono::nanoseconds(most);
}

}  // namespace handgraft::server
