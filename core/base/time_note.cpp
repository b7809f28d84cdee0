#include "core/base/time_note.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"

namespace handgraft {

std::string timeUnitNote(const std::vector<double>& time_s) {
  // Fewer may be keys that somebody set by hand.
  constexpr std::size_t kFewest = 5;
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
  std::vector<double> intervals;
  for (std::size_t k = 1; k < time_s.size(); ++k)
    intervals.push_back(time_s[k] - time_s[k - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  for (const Unit& unit : kUnits) {
    if (*middle < kClosest * unit.in_milliseconds || *middle > kFarthest * unit.in_milliseconds)
      continue;
    return fmt::format(
        "its frames are {:.4g} s apart: are these {}? Times are in seconds, and the hand goes "
        "{} times too slowly then",
        *middle, unit.plural, unit.times);
  }
  return "";
}

}  // namespace handgraft
