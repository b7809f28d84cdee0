#pragma once

#include <array>
#include <string_view>

#include "hardware/devices/examples/line_wire.h"

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// The microcontroller of `LineHand`, as its own program would do it.
class LineHandEmulator final : public EmulatedDevice {
 public:
  LineHandEmulator();

  void hear(protocols::Bytes bytes, TimePoint now) override;
  void advance(TimePoint now) override;

  std::array<EmulatedServo, 3> servos;  ///< 0.1 mrad
  std::chrono::milliseconds watchdog{100};
  int broken_motor = -1;
  int state = devices::LineState::kOff;

 private:
  void obey(std::string_view text, TimePoint now);

  protocols::StreamReader<devices::LineFraming> reader_;
  TimePoint time_;
  TimePoint heard_;
};

}  // namespace handgraft::test
