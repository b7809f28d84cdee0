#include "hardware/devices/motor_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::devices {

namespace {

// Which way rounding went too far: 1 upwards, -1 downwards, 0 not.
int excess(const MotorScale& scale, double wanted, double rounded) {
  if (rounded > scale.upper && rounded > wanted) return 1;
  if (rounded < scale.lower && rounded < wanted) return -1;
  return 0;
}

}  // namespace

std::int32_t MotorScale::wholeUnits(double angle_rad,
                                    std::int32_t least,
                                    std::int32_t most) const {
  HANDGRAFT_REQUIRE(std::isfinite(angle_rad));
  double rounded = std::round(units(angle_rad));
  rounded -= direction * excess(*this, angle_rad, angle(rounded));
  return static_cast<std::int32_t>(
      std::clamp(rounded, static_cast<double>(least), static_cast<double>(most)));
}

float MotorScale::floatUnits(double angle_rad) const {
  HANDGRAFT_REQUIRE(std::isfinite(angle_rad));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto rounded = static_cast<float>(units(angle_rad));
  const int too_far = direction * excess(*this, angle_rad, angle(rounded));
  return too_far == 0 ? rounded : std::nextafter(rounded, too_far > 0 ? -kInfinity : kInfinity);
}

void validate(const MotorScale& scale, const std::string& motor, double least, double most) {
  if (scale.direction != 1 && scale.direction != -1)
    rejectInput("motor {}: direction {} is neither 1 nor -1", motor, scale.direction);
  if (!std::isfinite(scale.zero))
    rejectInput("motor {}: zero {} is not finite", motor, scale.zero);
  if (!(scale.rad_per_unit > 0.0) || !std::isfinite(scale.rad_per_unit)) {
    rejectInput("motor {}: {} rad per unit is not positive and finite", motor,
                scale.rad_per_unit);
  }
  if (!std::isfinite(scale.lower) || !std::isfinite(scale.upper) ||
      !(scale.lower < scale.upper)) {
    rejectInput("motor {}: limits {} to {} rad are no range", motor, scale.lower, scale.upper);
  }
  const auto [low, high] = std::minmax({scale.units(scale.lower), scale.units(scale.upper)});
  if (low < least || high > most) {
    rejectInput("motor {}: limits {} to {} rad are {} to {} units, outside {} to {}", motor,
                scale.lower, scale.upper, low, high, least, most);
  }
}

}  // namespace handgraft::devices
