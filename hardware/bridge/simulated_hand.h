#pragma once

#include <functional>

#include "hardware/bridge/hand_driver.h"

namespace handgraft::bridge {

/// One servo: its mechanical stops, its top speed, where it stands when it is switched on.
struct SimulatedJoint {
  double lower;     ///< rad; -inf without a stop
  double upper;     ///< rad; inf without a stop
  double velocity;  ///< rad/s
  double start;     ///< rad
};

/// A hand of first-order servos: each joint approaches what it was sent with a time constant,
/// at most at its top speed, and stops at its mechanical stops. Without power it stays where it
/// is, as a hand with self-locking gears does.
///
/// The motion between two calls is the closed-form answer, so it does not depend on how often
/// the hand is asked, and time may be virtual.
class SimulatedHand final : public HandDriver {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  static constexpr double kTimeConstant =
      0.03;  // s; small geared servos reach 63 % in 20-50 ms

  /// Errors: InvalidInput for an empty range, a start that is not finite, a top speed or a time
  /// constant that is not positive. A start outside the stops is moved onto them.
  explicit SimulatedHand(std::vector<SimulatedJoint> joints,
                         Clock clock = std::chrono::steady_clock::now,
                         double time_constant_s = kTimeConstant);

  void open() override;
  void read(JointReading& reading) override;
  /// Errors: DeviceError before `open`, for a wrong count, or for a value that is not finite.
  void write(std::span<const double> targets) override;
  void stop() override;

 private:
  struct Servo {
    SimulatedJoint joint;
    double position;
    double goal;
  };

  void advance();
  double velocityOf(const Servo& servo) const;

  Clock clock_;
  double time_constant_;
  std::chrono::steady_clock::time_point now_{};
  bool is_open_ = false;
  std::vector<Servo> servos_;
};

}  // namespace handgraft::bridge
