#pragma once

#include <array>

#include "hardware/protocols/inspire_table.h"
#include "hardware/protocols/modbus_rtu.h"

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// An Inspire RH56: its registers behind Modbus RTU, fingers that run to their set angles at
/// their set speeds, errors that stay until they are cleared. It has no watchdog.
class InspireEmulator final : public EmulatedDevice {
 public:
  InspireEmulator();

  void hear(protocols::Bytes bytes, TimePoint now) override;
  void advance(TimePoint now) override;

  struct Finger {
    EmulatedServo servo;  ///< units of the way, 1000 open
    std::uint16_t set = 1000, force = 500, speed = 0;
    std::int16_t force_g = 0, current_milliamp = 0;
    std::uint8_t error = 0, temperature = 30;
    bool is_broken = false;  ///< its error comes back
  };

  std::array<Finger, protocols::inspire::kMotorCount> fingers;

 private:
  void obey(const protocols::modbus::Request& request, TimePoint now);
  [[nodiscard]] std::uint16_t registerAt(std::size_t address) const;

  protocols::StreamReader<protocols::modbus::RequestFraming> reader_;
  TimePoint time_;
};

}  // namespace handgraft::test
