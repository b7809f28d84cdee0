#pragma once

#include <vector>

#include "hardware/devices/device.h"

namespace handgraft::bridge {

/// One servo: its mechanical stops, its top speed, where it stands when it is switched on.
struct SimulatedMotor {
  double lower;     ///< rad
  double upper;     ///< rad
  double velocity;  ///< rad/s
  double start;     ///< rad
};

/// Motors that are not there: first-order servos, each of which approaches what it was sent
/// with a time constant, at most at its top speed, and stops at its mechanical stops. Without
/// power they stay where they are, as self-locking gears do.
///
/// The motion between two calls is the closed-form answer, so it does not depend on how often
/// they are asked, and time may be virtual. They have no watchdog: their power ends with us.
class SimulatedDevice final : public devices::Device {
 public:
  static constexpr double kTimeConstant =
      0.03;  // s; small geared servos reach 63 % in 20-50 ms

  /// Errors: InvalidInput for an empty range, a start that is not finite, a top speed or a time
  /// constant that is not positive. A start outside the stops is moved onto them.
  explicit SimulatedDevice(const std::vector<SimulatedMotor>& motors,
                           devices::Clock clock,
                           double time_constant_s = kTimeConstant);

  [[nodiscard]] std::size_t motorCount() const override { return servos_.size(); }

  [[nodiscard]] devices::DeviceCounters counters() const override { return {}; }

 private:
  struct Servo {
    SimulatedMotor motor;
    double position;
    double goal;
  };

  void doOpen() override;
  void doArm() override;
  void doRead(devices::DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;

  void doHeal() override {}

  void advance();
  [[nodiscard]] double velocityOf(const Servo& servo) const;

  devices::Clock clock_;
  double time_constant_;
  devices::TimePoint now_{};
  std::vector<Servo> servos_;
};

}  // namespace handgraft::bridge
