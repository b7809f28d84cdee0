#pragma once

#include "hardware/tendon/motor_map.h"

namespace handgraft::tendon {

/// Between a map's motor angles and the device's: device = direction * gear * motor + zero.
/// `direction` and `zero` come from calibration, `gear` from the build of the hand.
struct MotorScale {
  double direction = 1;  ///< 1 or -1
  double gear = 1;       ///< motor turns per turn of the map's motor, positive
  double zero_rad = 0;   ///< the device's angle where the map's is 0

  [[nodiscard]] double toDevice(double motor_rad) const {
    return direction * gear * motor_rad + zero_rad;
  }

  [[nodiscard]] double fromDevice(double device_rad) const {
    return direction * (device_rad - zero_rad) / gear;
  }

  [[nodiscard]] Range toDevice(const Range& motor_rad) const {
    const double a = toDevice(motor_rad.lower), b = toDevice(motor_rad.upper);
    return a < b ? Range{a, b} : Range{b, a};
  }
};

}  // namespace handgraft::tendon
