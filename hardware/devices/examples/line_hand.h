#pragma once

#include <array>

#include "hardware/devices/device.h"
#include "hardware/devices/examples/line_wire.h"
#include "hardware/devices/motor_scale.h"

namespace handgraft::devices {

struct LineHandConfig {
  std::array<MotorScale, 3> scales;  ///< units are 0.1 mrad
  Duration watchdog = std::chrono::milliseconds(100);
  Duration reply_timeout = std::chrono::milliseconds(5);
  int tolerated_misses = 3;  ///< answers in a row
};

/// Three servos behind a microcontroller of one's own: the example of how a device is made.
///
/// It is told `?`, `on`, `off` or targets, and answers each by its state. Without a word for as
/// long as its watchdog it switches itself off, until it is told `off`.
class LineHand final : public Device {
 public:
  /// `bytes` has to live as long as this. Errors: InvalidInput for limits that are none.
  LineHand(LineHandConfig config, ByteChannel& bytes, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override { return config_.scales.size(); }

  [[nodiscard]] DeviceCounters counters() const override { return wire_.counters(); }

 private:
  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;

  void ask(const char* text);  // until it is answered
  void findFaults();

  LineHandConfig config_;
  Clock clock_;
  LineWire wire_;
  bool is_owed_ = false;  // an answer to targets
  bool expects_power_ = false;
  int misses_ = 0;
};

}  // namespace handgraft::devices
