#pragma once

#include "hardware/config/hand_config.h"

namespace handgraft::config {

/// Of a period, what a cycle may take on the wire: the rest is for the device's own time to
/// answer and for what is late.
inline constexpr double kWireShare = 0.8;

/// What reading and writing all motors once takes on the wire of `config`, s: its bytes or
/// frames at its rate. 0 for a simulated hand.
///
/// Source: the protocols' frames (hardware/protocols). A CAN frame of n bytes is taken for
/// 47 + 8 n bits and one stuffed bit in five.
double cycleTime(const HandConfig& config);

}  // namespace handgraft::config
