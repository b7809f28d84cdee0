#pragma once

#include <array>

#include "hardware/devices/can_channel.h"
#include "hardware/devices/device.h"
#include "hardware/devices/motor_scale.h"
#include "hardware/protocols/allegro_can.h"

namespace handgraft::devices {

struct AllegroConfig {
  /// In the hand's own order: index, middle, little, thumb, four each from the palm on; counts.
  std::array<MotorScale, protocols::allegro::kMotorCount> scales;
  std::array<std::size_t, protocols::allegro::kMotorCount> order{0, 1, 2,  3,  4,  5,  6,  7,
                                                                 8, 9, 10, 11, 12, 13, 14, 15};
  double stiffness = 0.6;  ///< Nm/rad
  double damping = 0.02;   ///< Nm s/rad
  double torque = 0.3;     ///< Nm, the most of each motor, at most 1
  Duration reply_timeout = std::chrono::milliseconds(3);  ///< of all fingers together
  int tolerated_misses = 3;                               ///< answers in a row
};

/// An Allegro Hand on a CAN bus: it takes torques alone, so the position loop is here:
/// stiffness times what a joint is off, less damping times its speed, within the largest
/// torque. It wants a period of 2 or 3 ms.
///
/// In each cycle all four fingers are asked for their joints, one in turn for its temperatures.
///
/// **It has no watchdog that is documented**: should this process die, each motor keeps the
/// torque that it was told last. Only its power switch ends that.
class AllegroHand final : public Device {
 public:
  /// `can` has to live as long as this. Errors: InvalidInput, naming the value.
  AllegroHand(const AllegroConfig& config, CanChannel& can, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override { return config_.scales.size(); }

  [[nodiscard]] DeviceCounters counters() const override;

 private:
  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;

  bool ask();
  void askSurely();
  void take(const protocols::CanFrame& frame);
  void sendTorques();

  AllegroConfig config_;
  CanChannel& can_;
  Clock clock_;
  // In the hand's own order.
  std::array<double, protocols::allegro::kMotorCount> angles_{};      // rad
  std::array<double, protocols::allegro::kMotorCount> velocities_{};  // rad/s
  std::array<double, protocols::allegro::kMotorCount> temperatures_{};
  std::array<std::int16_t, protocols::allegro::kMotorCount> pwm_{};
  std::array<bool, protocols::allegro::kFingerCount> is_answered_{};
  std::array<TimePoint, protocols::allegro::kFingerCount> times_{};
  std::array<int, protocols::allegro::kFingerCount> misses_{};
  std::size_t turn_ = 0;
  bool expects_power_ = false;
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
