#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bringup/jog.h"

namespace handgraft::bringup {

/// Who walks along: is asked, and answers.
struct Operator {
  std::function<void(const std::string& line)> say;
  /// A line, without its end; nothing when there is nobody any more.
  std::function<std::optional<std::string>(const std::string& question)> ask;
  IsHeld is_held;
  /// There is nobody any more, or whoever is there wants to end.
  std::function<bool()> has_left = [] {
    return false;
  };
};

struct MotorFinding {
  std::string motor;
  bool is_direction_right = false;
  double zero_rad = 0;                     ///< the encoder's angle at the joint's zero
  double lowest_rad = 0, highest_rad = 0;  ///< reached by hand, from that zero
  std::string objection;  ///< empty: the config's range lies within what it reaches
};

struct Findings {
  std::vector<MotorFinding> motors;
  bool has_watchdog = false;
  bool lacks_watchdog = false;  ///< such a device has none, and its config accepts that
  bool has_stop = false;
  std::string trouble;  ///< why the walk ended early; empty: it did not

  [[nodiscard]] bool isFine() const;
};

/// A guided walk through a hand before it is trusted: each motor's zero, direction and range,
/// its joint moved by hand and by a slow jog; then that the device's own watchdog stops the
/// motors, and that its emergency stop does. `config` gets the directions and zeros that were
/// found. A hand that knows its zeros is not moved by hand: each motor turns, and that is all.
///
/// Nothing turns but a jog of 0.1 rad that is held for, and motors that hold where they stand.
/// Nobody is asked to put a hand in before the device is open: its motors are off then, and
/// while the hand is in nobody else can open its port. What fails at the device is told, and
/// tried again if the person agrees. A person who leaves or does not agree ends the walk
/// (`trouble`), with what was found until then.
Findings check(config::HandConfig& config,
               const bridge::MakeDevice& make_device,
               const devices::Clock& clock,
               const std::function<void(devices::TimePoint)>& sleep_until,
               const Operator& person);

/// To keep.
std::string reportText(const config::HandConfig& config, const Findings& findings);

}  // namespace handgraft::bringup
