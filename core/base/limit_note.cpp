#include "core/base/limit_note.h"

#include <algorithm>
#include <numbers>

#include "core/base/error.h"

namespace handgraft {

std::string limitNote(const std::string& joint,
                      bool slides,
                      const JointRange& limits,
                      const JointRange& own) {
  // No joint of a hand goes round more than once, and none slides as far as this.
  constexpr double kTurn = 2.0 * std::numbers::pi;  // rad
  constexpr double kLongestTravel = 1.0;            // m
  const double most = slides ? kLongestTravel : kTurn;
  if (limits.lower >= std::min(-most, own.lower) && limits.upper <= std::max(most, own.upper)) {
    constexpr double kSame = 1e-6;  // what degrees lose as they are written
    if (limits.lower >= own.lower - kSame && limits.upper <= own.upper + kSame) return "";
    return fmt::format(
        "limits {:.4g} to {:.4g} {} of joint {} go beyond the hand's own, {:.4g} to {:.4g}: "
        "the hand as it is built cannot take poses there",
        limits.lower, limits.upper, slides ? "m" : "rad", quoted(joint), own.lower, own.upper);
  }
  return slides ? fmt::format(
                      "limits {:.4g} to {:.4g} m of joint {} are beyond {:.4g} m; sliders are "
                      "in metres, not millimetres",
                      limits.lower, limits.upper, quoted(joint), most)
                : fmt::format(
                      "limits {:.4g} to {:.4g} rad of joint {} go round more than once; angles "
                      "are radians, not degrees",
                      limits.lower, limits.upper, quoted(joint));
}

}  // namespace handgraft
