#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace handgraft::bench {

using Clock = std::chrono::steady_clock;

inline double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// The value below which `share` of them lie; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Least time of `repeats` calls, ms: what the work takes when nothing else runs.
template <class Work>
double leastMilliseconds(int repeats, const Work& work) {
  double least = 0.0;
  for (int i = 0; i < repeats; ++i) {
    const Clock::time_point start = Clock::now();
    work();
    const double time = millisecondsSince(start);
    least = i == 0 ? time : std::min(least, time);
  }
  return least;
}

}  // namespace handgraft::bench
