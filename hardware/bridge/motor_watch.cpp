#include "hardware/bridge/motor_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace handgraft::bridge {

namespace {

constexpr double kPushing = 0.95;   // of the current that a motor may use
constexpr double kStanding = 0.05;  // of its speed

template <class... Args>
void say(FixedText& to, fmt::format_string<Args...> format, Args&&... args) {
  std::array<char, 160> text{};
  const auto end =
      fmt::format_to_n(text.data(), text.size(), format, std::forward<Args>(args)...);
  to.set({text.data(), std::min(end.size, text.size())});
}

std::string_view shortNameOf(const config::MotorConfig& motor) {
  return std::string_view(motor.name).substr(0, 60);
}

}  // namespace

bool MotorWatch::isAnyHeldBack(const config::HandConfig& config,
                               const devices::DeviceState& measured,
                               bool is_armed,
                               safety::Time now) {
  bool is_held = false;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const config::MotorConfig& motor = config.motors[i];
    const double speed = std::abs(measured.velocity[i]);
    const double current_A = std::abs(measured.current[i]);
    const bool pushes = is_armed && motor.current_A > 0 &&
                        current_A >= kPushing * motor.current_A &&
                        !(speed > kStanding * motor.velocity_rad_s);
    if (!pushes) free_since_[i] = now;
    const bool is_hot = measured.temperature[i] >= config.hot_c;
    const bool is_stalled = now - free_since_[i] > config.stalled_for;
    if (measured.limited[i] == 0 && !is_hot && !is_stalled) continue;
    if (is_held) continue;
    is_held = true;
    const std::string_view name = shortNameOf(motor);
    if (is_hot) {
      say(held_, "motor '{}' is hot: {:.0f} degrees C", name, measured.temperature[i]);
    } else if (is_stalled) {
      say(held_, "motor '{}' is stalled: it pushed with {:.2f} A for {:.3g} s", name, current_A,
          std::chrono::duration<double>(config.stalled_for).count());
    } else {
      say(held_, "motor '{}' is held back by its device, hot or blocked", name);
    }
  }
  return is_held;
}

bool MotorWatch::isAnyOutside(const config::HandConfig& config,
                              const devices::DeviceState& measured) {
  outside_.set("");
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const config::MotorConfig& motor = config.motors[i];
    const double at = measured.position[i];
    const double slack = config.motor_outside_rad;
    // NaN is none of our business here: a measured pose of it is no pose.
    if (!(at < motor.range_rad.lower - slack) && !(at > motor.range_rad.upper + slack))
      continue;
    say(outside_, "'{}' is at {:.2f} rad, its range {:.4g} to {:.4g}", shortNameOf(motor), at,
        motor.range_rad.lower, motor.range_rad.upper);
    return true;
  }
  return false;
}

void noteMotors(const config::HandConfig& config,
                const devices::DeviceState& measured,
                const std::vector<std::size_t>& joint_of_motor,
                MotionState& state) {
  state.temperature_c = -1;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    const double told = measured.temperature[i];
    if (std::isfinite(told)) state.temperature_c = std::max(state.temperature_c, told);
    state.motor_current[i] = measured.current[i];
    state.motor_temperature[i] = told;
    if (i >= joint_of_motor.size()) continue;
    const std::size_t joint = joint_of_motor[i];
    const std::optional<double> torque_Nm_A = config.motors[i].torque_Nm_A;
    const double per_A =
        torque_Nm_A ? *torque_Nm_A / config.governor.limits[joint].travel : 1.0;
    state.effort[joint] = per_A * measured.current[i];
  }
}

}  // namespace handgraft::bridge
