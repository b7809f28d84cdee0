#pragma once

#include <functional>
#include <string>

#include "hardware/bridge/device_factory.h"
#include "hardware/config/hand_config.h"

namespace handgraft::bringup {

/// Whether somebody still holds the dead-man's switch; asked once a period.
using IsHeld = std::function<bool()>;

/// One motor of a hand whose zeros and directions nobody knows yet: where it is, and a slow
/// turn by a step. Its own range says nothing as yet, so that of the turn bounds it; the other
/// motors hold where they stand. The device's own limits are set for it: at most
/// `kJogSpeed`.
class Jogger {
 public:
  /// Errors: InvalidInput if no motor has that name.
  Jogger(config::HandConfig config,
         const std::string& motor,
         bridge::MakeDevice make_device,
         devices::Clock clock,
         std::function<void(devices::TimePoint)> sleep_until);

  struct Place {
    double motor_rad = 0;    ///< by the config's zero and direction
    double encoder_rad = 0;  ///< as the device counts
  };

  /// Motors stay off. Errors: TransportError, DeviceError.
  Place look();

  struct Turn {
    Place from, to;
    bool was_let_go = false;  ///< it stopped before the end
    double largest_A = 0;     ///< NaN: not told
  };

  /// Turns by `step_rad`, for as long as `is_held`; once let go it brakes. Motors are off
  /// afterwards, whatever happens.
  /// Errors: InvalidInput for a step outside +-0.5 rad, or beyond the range of a motor that
  /// knows its zero; TransportError, DeviceError.
  Turn turn(double step_rad, const IsHeld& is_held);

  [[nodiscard]] const config::MotorConfig& motor() const { return config_.motors[index_]; }

 private:
  [[nodiscard]] Place placeOf(double motor_rad) const;
  /// That bounds a turn by `step_rad` from `start_rad`. Errors: InvalidInput beyond the range
  /// of a motor that knows its zero.
  [[nodiscard]] tendon::Range rangeOfTurn(double start_rad, double step_rad) const;

  config::HandConfig config_;
  std::size_t index_;
  bridge::MakeDevice make_device_;
  devices::Clock clock_;
  std::function<void(devices::TimePoint)> sleep_until_;
};

inline constexpr double kJogSpeed = 0.3;    // rad/s
inline constexpr double kLargestJog = 0.5;  // rad

}  // namespace handgraft::bringup
