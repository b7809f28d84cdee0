#pragma once

#include <array>
#include <vector>

#include "hardware/protocols/allegro_can.h"

#include "tests/hardware/emulators/can_bus.h"

namespace handgraft::test {

/// An Allegro Hand on a CAN bus: joints that torques push through a viscous oil, the faster the
/// stronger; poses and temperatures when asked. It keeps its last torques: it has no watchdog.
class AllegroEmulator final : public CanBus {
 public:
  AllegroEmulator();

  void hear(const protocols::CanFrame& frame, TimePoint now) override;
  void advance(TimePoint now) override;
  std::vector<protocols::CanFrame> takeFrames() override;

  /// Its power switch, off and on again: it is off, and has no torques.
  void switchOff();

  static constexpr double kOil = 0.1;  // Nm s/rad

  struct Joint {
    double counts = 0;
    std::int16_t pwm = 0;
  };

  std::array<Joint, protocols::allegro::kMotorCount> joints;
  bool is_on = false;
  bool is_broken = false;  ///< its second finger does not answer

 private:
  std::vector<protocols::CanFrame> said_;
  TimePoint time_;
};

}  // namespace handgraft::test
