#pragma once

#include <span>
#include <string>
#include <vector>

#include "hardware/bridge/motion_state.h"
#include "hardware/config/hand_config.h"
#include "hardware/safety/governor_types.h"

namespace handgraft::bridge {

v1::BridgeRefusal codeOf(safety::Refusal refusal);

/// What the limits took of a pose: how much at most, and which joint by name.
struct Clamping {
  double largest_rad = 0;  ///< at the motor, of a joint that slides
  FixedText text;          ///< empty: nothing
};

/// Allocates nothing.
Clamping clampingOf(const safety::GovernorOptions& options,
                    std::span<const double> asked,
                    std::span<const double> given);

/// A device that is gone, or that told nothing for too long, by its port: nobody knows whether
/// its motors are off, and what stops them.
std::string lostText(safety::FaultCause cause, const config::DeviceConfig& device);

/// Which joint is measured farthest beyond its limits, if any is by more than `outside`; else
/// empty. Allocates nothing.
FixedText outsideText(const safety::GovernorOptions& options, std::span<const double> measured);

/// A device's fault with its motor, id and joint, and what the device says in words; of a
/// motor that does not answer, that nobody knows whether it is off.
/// `joint_of_motor`: of direct drive, an index for each motor; else empty.
std::string faultText(const devices::Device& device,
                      const config::HandConfig& config,
                      const std::vector<std::size_t>& joint_of_motor);

}  // namespace handgraft::bridge
