#pragma once

#include <algorithm>

namespace handgraft {

/// From 0 to 1 as `share` goes there, without a bend at either end; 0 before, 1 behind.
constexpr double smoothStep(double share) {
  const double t = std::clamp(share, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace handgraft
