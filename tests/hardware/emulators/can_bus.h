#pragma once

#include <vector>

#include "hardware/protocols/can_frame.h"

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// Devices on a CAN bus, in whatever time they are told.
class CanBus {
 public:
  virtual ~CanBus() = default;

  virtual void hear(const protocols::CanFrame& frame, TimePoint now) = 0;
  virtual void advance(TimePoint now) = 0;
  virtual std::vector<protocols::CanFrame> takeFrames() = 0;
};

}  // namespace handgraft::test
