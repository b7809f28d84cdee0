#include "hardware/tendon/extension.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace handgraft::tendon {

namespace {

constexpr int kSamples = 128;  // of a range; curves of one joint bend once or twice

double sampleOf(const Range& range, int i) {
  return range.lower + (range.upper - range.lower) * i / kSamples;
}

}  // namespace

Extension Extension::constantArm(double arm_m) {
  if (!std::isfinite(arm_m)) rejectInput("moment arm {} m is not finite", arm_m);
  return {Kind::kConstant, arm_m, 0, 0};
}

Extension Extension::quadratic(double arm_m, double curvature_m) {
  if (!std::isfinite(arm_m) || !std::isfinite(curvature_m))
    rejectInput("moment arm {} m with curvature {} m is not finite", arm_m, curvature_m);
  return {Kind::kQuadratic, arm_m, curvature_m, 0};
}

Extension Extension::channel(double before_m, double after_m, double height_m) {
  if (!(before_m > 0) || !(after_m > 0) || !std::isfinite(before_m) || !std::isfinite(after_m))
    rejectInput("channel exits {} m and {} m from the axis must be positive and finite",
                before_m, after_m);
  if (!(height_m >= 0) || !std::isfinite(height_m))
    rejectInput("channel height {} m is not in [0, inf)", height_m);
  return {Kind::kChannel, std::hypot(before_m, height_m), std::hypot(after_m, height_m),
          std::numbers::pi - std::atan2(height_m, before_m) - std::atan2(height_m, after_m)};
}

Extension::Value Extension::at(double q) const {
  switch (kind_) {
    case Kind::kConstant:
      return {a_ * q, a_, 0};
    case Kind::kQuadratic:
      return {a_ * q + b_ * q * q / 2, a_ + b_ * q, b_};
    case Kind::kChannel:
      break;
  }
  const double ab = a_ * b_;
  const double g = c_ - q;
  const auto length_at = [&](double angle) {
    return std::sqrt(std::max(0.0, a_ * a_ + b_ * b_ - 2 * ab * std::cos(angle)));
  };
  const double length = length_at(g);
  const double slope = ab * std::sin(g) / length;  // -dl/dq, since dg/dq = -1
  // d/dq of A B sin g / l = (-A B cos g + r^2) / l, with dl/dq = -r.
  return {length_at(c_) - length, slope, (slope * slope - ab * std::cos(g)) / length};
}

Range Extension::slopes(const Range& range) const {
  Range bounds{at(range.lower).slope, at(range.lower).slope};
  for (int i = 1; i <= kSamples; ++i) {
    const double slope = at(sampleOf(range, i)).slope;
    bounds = {std::min(bounds.lower, slope), std::max(bounds.upper, slope)};
  }
  return bounds;
}

Range Extension::excursions(const Range& range) const {
  Range bounds{at(range.lower).e, at(range.lower).e};
  for (int i = 1; i <= kSamples; ++i) {
    const double e = at(sampleOf(range, i)).e;
    bounds = {std::min(bounds.lower, e), std::max(bounds.upper, e)};
  }
  return bounds;
}

double Extension::largestCurvature(const Range& range) const {
  double largest = at(range.lower).curvature;
  for (int i = 1; i <= kSamples; ++i)
    largest = std::max(largest, at(sampleOf(range, i)).curvature);
  return largest;
}

}  // namespace handgraft::tendon
