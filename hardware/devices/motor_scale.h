#pragma once

#include <cstdint>
#include <string>

namespace handgraft::devices {

/// One motor's angle in rad, and in the unit of its device:
/// unit = zero + direction * angle / rad_per_unit.
struct MotorScale {
  double rad_per_unit = 1.0;
  double zero = 0.0;   ///< in units: where the angle is 0
  int direction = 1;   ///< 1, or -1 if the device counts the other way
  double lower = 0.0;  ///< rad
  double upper = 0.0;  ///< rad

  [[nodiscard]] double angle(double units) const {
    return direction * (units - zero) * rad_per_unit;
  }

  [[nodiscard]] double units(double angle_rad) const {
    return zero + direction * angle_rad / rad_per_unit;
  }

  /// The whole unit nearest to `angle_rad`; never beyond `lower` and `upper`, nor farther
  /// beyond than the angle itself, and within `least` and `most`. At most one unit off.
  /// `angle_rad` has to be finite.
  [[nodiscard]] std::int32_t wholeUnits(double angle_rad,
                                        std::int32_t least,
                                        std::int32_t most) const;

  /// The same for a device that takes a float.
  [[nodiscard]] float floatUnits(double angle_rad) const;
};

/// Errors: InvalidInput, naming `motor`, for a direction other than 1 and -1, a range that is
/// empty or not finite, or limits that the device cannot express in [least, most] units.
void validate(const MotorScale& scale, const std::string& motor, double least, double most);

}  // namespace handgraft::devices
