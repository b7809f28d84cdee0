#include "hardware/bridge/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::bridge {

SimulatedDevice::SimulatedDevice(const std::vector<SimulatedMotor>& motors,
                                 devices::Clock clock,
                                 double time_constant_s)
    : clock_(std::move(clock)), time_constant_(time_constant_s) {
  if (!(time_constant_ > 0) || !std::isfinite(time_constant_)) {
    rejectInput("time constant {} s is not positive and finite", time_constant_);
  }
  servos_.reserve(motors.size());
  for (std::size_t i = 0; i < motors.size(); ++i) {
    const SimulatedMotor& motor = motors[i];
    if (!(motor.lower <= motor.upper)) {
      rejectInput("simulated motor {}: its stops [{}, {}] leave no room", i, motor.lower,
                  motor.upper);
    }
    if (!(motor.velocity > 0)) {
      rejectInput("simulated motor {}: top speed {} is not positive", i, motor.velocity);
    }
    const double start = std::clamp(motor.start, motor.lower, motor.upper);
    if (!std::isfinite(start)) {
      rejectInput("simulated motor {}: start {} is not finite", i, motor.start);
    }
    servos_.push_back({motor, start, start});
  }
}

void SimulatedDevice::doOpen() {
  doStop();
}

void SimulatedDevice::doArm() {
  doStop();
}

void SimulatedDevice::doRead(devices::DeviceState& state) {
  advance();
  state.time = now_;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    state.position[i] = servos_[i].position;
    state.velocity[i] = velocityOf(servos_[i]);
  }
}

void SimulatedDevice::doWrite(std::span<const double> targets) {
  advance();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const SimulatedMotor& motor = servos_[i].motor;
    servos_[i].goal = std::clamp(targets[i], motor.lower, motor.upper);
  }
}

bool SimulatedDevice::doDisarm() {
  doStop();
  return true;
}

void SimulatedDevice::doStop() {
  advance();
  for (Servo& servo : servos_)
    servo.goal = servo.position;
}

double SimulatedDevice::velocityOf(const Servo& servo) const {
  const double wanted = (servo.goal - servo.position) / time_constant_;
  return std::clamp(wanted, -servo.motor.velocity, servo.motor.velocity);
}

// dq/dt = clamp((goal - q) / tau, -V, V): a straight line while the error is above V tau, then
// an exponential.
void SimulatedDevice::advance() {
  const devices::TimePoint now = clock_();
  if (now <= now_) return;  // a clock that stands still or steps back moves nothing
  const double elapsed = std::chrono::duration<double>(now - now_).count();
  now_ = now;
  for (Servo& servo : servos_) {
    const double error = servo.goal - servo.position;
    const double linear_range = servo.motor.velocity * time_constant_;
    const double excess = std::abs(error) - linear_range;
    const double at_top_speed = excess > 0 ? excess / servo.motor.velocity : 0.0;
    if (elapsed < at_top_speed) {
      servo.position += std::copysign(servo.motor.velocity * elapsed, error);
      continue;
    }
    const double left = excess > 0 ? std::copysign(linear_range, error) : error;
    servo.position = servo.goal - left * std::exp(-(elapsed - at_top_speed) / time_constant_);
  }
}

}  // namespace handgraft::bridge
