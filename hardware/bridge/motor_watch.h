#pragma once

#include <vector>

#include "hardware/bridge/motion_state.h"
#include "hardware/config/hand_config.h"
#include "hardware/safety/governor_types.h"

namespace handgraft::bridge {

/// What measured motors say: that one is held back (its device says so, it is hot, or it pushes
/// as hard as it may for long, and stands), or stands far outside its own range. Allocates
/// nothing once made.
class MotorWatch {
 public:
  MotorWatch(std::size_t motors, safety::Time start) : free_since_(motors, start) {}

  bool isAnyHeldBack(const config::HandConfig& config,
                     const devices::DeviceState& measured,
                     bool is_armed,
                     safety::Time now);

  bool isAnyOutside(const config::HandConfig& config, const devices::DeviceState& measured);

  /// Which one was held back last, and why.
  [[nodiscard]] const FixedText& held() const { return held_; }

  /// Which one is outside, and by how much; empty: none.
  [[nodiscard]] const FixedText& outside() const { return outside_; }

 private:
  std::vector<safety::Time> free_since_;  // each motor, since it last did not push in vain
  FixedText held_, outside_;
};

/// Currents, temperatures and efforts into `state`. `joint_of_motor`: of direct drive, an index
/// for each motor; else empty.
void noteMotors(const config::HandConfig& config,
                const devices::DeviceState& measured,
                const std::vector<std::size_t>& joint_of_motor,
                MotionState& state);

}  // namespace handgraft::bridge
