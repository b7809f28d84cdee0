#include "hardware/bridge/simulated_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::bridge {

SimulatedHand::SimulatedHand(std::vector<SimulatedJoint> joints,
                             Clock clock,
                             double time_constant_s)
    : clock_(std::move(clock)), time_constant_(time_constant_s) {
  if (!(time_constant_ > 0) || !std::isfinite(time_constant_)) {
    rejectInput("time constant {} s is not positive and finite", time_constant_);
  }
  servos_.reserve(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const SimulatedJoint& joint = joints[i];
    if (!(joint.lower <= joint.upper)) {
      rejectInput("simulated joint {}: its stops [{}, {}] leave no room", i, joint.lower,
                  joint.upper);
    }
    if (!(joint.velocity > 0)) {
      rejectInput("simulated joint {}: top speed {} is not positive", i, joint.velocity);
    }
    const double start = std::clamp(joint.start, joint.lower, joint.upper);
    if (!std::isfinite(start)) {
      rejectInput("simulated joint {}: start {} is not finite", i, joint.start);
    }
    servos_.push_back({joint, start, start});
  }
}

void SimulatedHand::open() {
  now_ = clock_();
  is_open_ = true;
}

void SimulatedHand::read(JointReading& reading) {
  if (!is_open_) throw DeviceError("simulated hand: read before it was opened");
  advance();
  reading.time = now_;
  reading.position.resize(servos_.size());
  reading.velocity.resize(servos_.size());
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    reading.position[i] = servos_[i].position;
    reading.velocity[i] = velocityOf(servos_[i]);
  }
}

void SimulatedHand::write(std::span<const double> targets) {
  if (!is_open_) throw DeviceError("simulated hand: written before it was opened");
  if (targets.size() != servos_.size()) {
    throw DeviceError(fmt::format("simulated hand: {} targets for {} joints", targets.size(),
                                  servos_.size()));
  }
  if (!std::all_of(targets.begin(), targets.end(), [](double q) {
        return std::isfinite(q);
      })) {
    throw DeviceError("simulated hand: a target is not finite");
  }
  advance();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const SimulatedJoint& joint = servos_[i].joint;
    servos_[i].goal = std::clamp(targets[i], joint.lower, joint.upper);
  }
}

void SimulatedHand::stop() {
  if (!is_open_) return;
  advance();
  for (Servo& servo : servos_)
    servo.goal = servo.position;
}

double SimulatedHand::velocityOf(const Servo& servo) const {
  const double wanted = (servo.goal - servo.position) / time_constant_;
  return std::clamp(wanted, -servo.joint.velocity, servo.joint.velocity);
}

// dq/dt = clamp((goal - q) / tau, -V, V): a straight line while the error is above V tau, then
// an exponential.
void SimulatedHand::advance() {
  const auto now = clock_();
  if (now <= now_) return;  // a clock that stands still or steps back moves nothing
  const double elapsed = std::chrono::duration<double>(now - now_).count();
  now_ = now;
  for (Servo& servo : servos_) {
    const double error = servo.goal - servo.position;
    const double linear_range = servo.joint.velocity * time_constant_;
    const double excess = std::abs(error) - linear_range;
    const double at_top_speed = excess > 0 ? excess / servo.joint.velocity : 0.0;
    if (elapsed < at_top_speed) {
      servo.position += std::copysign(servo.joint.velocity * elapsed, error);
      continue;
    }
    const double left = excess > 0 ? std::copysign(linear_range, error) : error;
    servo.position = servo.goal - left * std::exp(-(elapsed - at_top_speed) / time_constant_);
  }
}

}  // namespace handgraft::bridge
