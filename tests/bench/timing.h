#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace handgraft::bench {

/// Processor time of this thread, ms: on an idle machine the time on the wall, on a busy one
/// what it would be.
inline double threadMilliseconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// The value below which `share` of them lie; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Least time of `repeats` calls, ms: what the work takes when nothing disturbs it.
template <class Work>
double leastMilliseconds(int repeats, const Work& work) {
  double least = 0.0;
  for (int i = 0; i < repeats; ++i) {
    const double start = threadMilliseconds();
    work();
    const double time = threadMilliseconds() - start;
    least = i == 0 ? time : std::min(least, time);
  }
  return least;
}

}  // namespace handgraft::bench
