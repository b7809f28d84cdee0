#pragma once

#include "hardware/protocols/ability_hand.h"

#include "tests/hardware/emulators/emulated_device.h"

namespace handgraft::test {

/// An Ability Hand: one reply to each accepted command, API mode until the exit command or
/// 300 ms of silence. In its own mode it stands still here.
class AbilityHandEmulator final : public EmulatedDevice {
 public:
  AbilityHandEmulator();

  void hear(protocols::Bytes bytes, TimePoint now) override;
  void advance(TimePoint now) override;

  std::array<EmulatedServo, protocols::ability_hand::kMotorCount> servos;  ///< counts
  bool is_in_api_mode = false;
  std::uint8_t limited = 0;
  std::array<std::uint16_t, protocols::ability_hand::kTouchCount> touch{};
  int exits = 0;  ///< exit commands heard

 private:
  void obey(const protocols::ability_hand::Command& command, TimePoint now);

  protocols::StreamReader<protocols::ability_hand::Framing> reader_;
  TimePoint time_;
  TimePoint heard_;
};

}  // namespace handgraft::test
