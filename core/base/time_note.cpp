#include "core/base/time_note.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"

namespace handgraft {

namespace {

// Fewer may be keys that somebody set by hand.
constexpr std::size_t kFewest = 5;

/// What is between most frames; at least two of them.
double usualInterval(const std::vector<double>& time_s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < time_s.size(); ++k)
    intervals.push_back(time_s[k] - time_s[k - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

}  // namespace

std::string timeUnitNote(const std::vector<double>& time_s) {
  // A recording has 5 to 200 frames a second: so far apart are they when counted in
  // thousandths.
  constexpr double kClosest = 5.0;
  constexpr double kFarthest = 200.0;

  struct Unit {
    const char* plural;
    double in_milliseconds;
    const char* times;
  };

  constexpr Unit kUnits[] = {{"milliseconds", 1.0, "1000"},
                             {"microseconds", 1e3, "a million"},
                             {"nanoseconds", 1e6, "10^9"}};

  if (time_s.size() < kFewest) return "";
  const double interval = usualInterval(time_s);
  for (const Unit& unit : kUnits) {
    if (interval < kClosest * unit.in_milliseconds ||
        interval > kFarthest * unit.in_milliseconds)
      continue;
    return fmt::format(
        "its frames are {:.4g} s apart: are these {}? Times are in seconds, and the hand goes "
        "{} times too slowly then",
        interval, unit.plural, unit.times);
  }
  return "";
}

std::string timeGapNote(const std::vector<double>& time_s) {
  constexpr double kShortestGap = 0.1;  // s
  constexpr double kOfUsual = 5.0;
  if (time_s.size() < kFewest) return "";
  const double least = std::max(kShortestGap, kOfUsual * usualInterval(time_s));
  int gaps = 0;
  double lost_s = 0.0;
  std::string first;
  for (std::size_t k = 1; k < time_s.size(); ++k) {
    const double gap_s = time_s[k] - time_s[k - 1];
    if (gap_s < least) continue;
    if (gaps == 0)
      first = fmt::format("{:.2f} s without frames at {:.2f} s", gap_s, time_s[k - 1]);
    lost_s += gap_s;
    ++gaps;
  }
  return gaps > 1 ? fmt::format("{}, {} such gaps of {:.2f} s in all", first, gaps, lost_s)
                  : first;
}

}  // namespace handgraft
