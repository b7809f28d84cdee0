#include "hardware/bridge/encoder_zero_monitor.h"

#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

#include "hardware/bridge/hand_homing.h"

namespace handgraft::bridge {

namespace {

// No device of ours restarts in less.
constexpr std::chrono::milliseconds kRestart(300);
// Half the least way that a marked encoder counts from 0: nothing else is so far off.
constexpr double kRestarted = kLeastMarkTurns * std::numbers::pi;  // rad

}  // namespace

EncoderZeroMonitor::EncoderZeroMonitor(const config::HandConfig& config)
    : are_known_((config.homing.empty() && config.calibration.empty()) ||
                 config.is_calibrated) {
  if (!are_known_ && config.homing.empty())
    why_.set("there is no calibration yet: `handgraft bridge check` makes one");
}

void EncoderZeroMonitor::find() {
  are_known_ = true;
  why_.set("");
}

void EncoderZeroMonitor::lose(std::string_view why) {
  are_known_ = false;
  why_.set(why);
}

void EncoderZeroMonitor::loseFor(std::string_view motor, std::string_view why) {
  std::array<char, 160> text{};
  const auto end =
      fmt::format_to_n(text.data(), text.size(), "motor '{}' {}", motor.substr(0, 60), why);
  lose({text.data(), std::min(end.size, text.size())});
}

void EncoderZeroMonitor::see(const config::HandConfig& config,
                             const devices::DeviceState& measured,
                             devices::TimePoint now) {
  if (config.homing.empty()) return;
  if (now - measured.time > kRestart) return noteAway();
  for (std::size_t i = 0; are_known_ && i < config.motors.size(); ++i) {
    const config::MotorConfig& motor = config.motors[i];
    if (motor.encoder != config::Encoder::kIncremental) continue;
    const double at = measured.position[i];
    const double beyond = std::max(motor.range_rad.lower - at, at - motor.range_rad.upper);
    if (motor.is_marked && beyond > kRestarted / motor.gear) {
      loseFor(motor.name, "restarted since it was homed");
    } else if (!motor.is_marked && was_away_) {
      loseFor(motor.name, "cannot say whether it restarted since it was homed");
    }
  }
  noteHeard();
}

}  // namespace handgraft::bridge
