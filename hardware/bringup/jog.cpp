#include "hardware/bringup/jog.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/safety/joint_limiter.h"

namespace handgraft::bringup {

namespace {

constexpr double kSlack = 2e-3;  // rad: of a range, so that a unit's rounding fits in
constexpr double kAccelerationPerSpeed = 10;  // 1/s: full speed after 0.1 s
constexpr double kJerkPerSpeed = 200;         // 1/s^2

std::size_t indexOf(const config::HandConfig& config, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    if (config.motors[i].name == name) return i;
    names += (i == 0 ? "" : ", ") + config.motors[i].name;
  }
  rejectInput("no motor is named {}; there are {}", quoted(name), names);
}

/// Motors off when it goes out of scope, also by an exception.
class Powered {
 public:
  explicit Powered(devices::Device& device) : device_(device) { device_.arm(); }

  ~Powered() {
    if (device_.isArmed() && !device_.disarm()) device_.stop();
  }

  Powered(const Powered&) = delete;
  Powered& operator=(const Powered&) = delete;

 private:
  devices::Device& device_;
};

void require(const devices::Device& device) {
  if (device.fault()) throw DeviceError(describe(device.fault()));
}

}  // namespace

Jogger::Jogger(config::HandConfig config,
               const std::string& motor,
               bridge::MakeDevice make_device,
               devices::Clock clock,
               std::function<void(devices::TimePoint)> sleep_until)
    : config_(std::move(config)),
      index_(indexOf(config_, motor)),
      make_device_(std::move(make_device)),
      clock_(std::move(clock)),
      sleep_until_(std::move(sleep_until)) {
  config::MotorConfig& ours = config_.motors[index_];
  ours.velocity_rad_s = std::min(ours.velocity_rad_s, kJogSpeed);
}

Jogger::Place Jogger::placeOf(double motor_rad) const {
  const config::MotorConfig& ours = config_.motors[index_];
  return {motor_rad, ours.zero_rad + ours.direction * ours.gear * motor_rad};
}

Jogger::Place Jogger::look() {
  bridge::DeviceStack stack = make_device_(config_);
  stack.device->open();
  devices::DeviceState measured(stack.device->motorCount());
  stack.device->read(measured);
  require(*stack.device);
  if (!std::isfinite(measured.position[index_]))
    throw DeviceError("the motor does not tell where it is");
  return placeOf(measured.position[index_]);
}

tendon::Range Jogger::rangeOfTurn(double start_rad, double step_rad) const {
  const double way = std::abs(step_rad) + kSlack;
  const tendon::Range around{start_rad - way, start_rad + way};
  if (!config::traitsOf(config_.device.kind).has_zeros) return around;
  const tendon::Range known = config_.motors[index_].range_rad;
  const tendon::Range range{std::max(around.lower, std::min(known.lower, start_rad)),
                            std::min(around.upper, std::max(known.upper, start_rad))};
  const double goal = start_rad + step_rad;
  if (goal < range.lower || goal > range.upper) {
    rejectInput("step {} rad: {} stands at {:.3f} rad, its range ends at {:.3f}", step_rad,
                handgraft::quoted(config_.motors[index_].name), start_rad,
                step_rad < 0 ? known.lower : known.upper);
  }
  return range;
}

Jogger::Turn Jogger::turn(double step_rad, const IsHeld& is_held) {
  if (!(std::abs(step_rad) <= kLargestJog) || step_rad == 0) {
    rejectInput("step {} rad is not in [-{}, {}], and not 0", step_rad, kLargestJog,
                kLargestJog);
  }
  Turn told;
  told.from = told.to = look();
  const double start = told.from.motor_rad;
  config::HandConfig wide = config_;
  wide.motors[index_].range_rad = rangeOfTurn(start, step_rad);
  bridge::DeviceStack stack = make_device_(wide);
  devices::Device& device = *stack.device;
  device.open();
  devices::DeviceState measured(device.motorCount());
  device.read(measured);
  require(device);
  if (!(std::abs(measured.position[index_] - start) < kSlack))
    throw DeviceError("the motor moves before it is told to");

  const double period_s = config_.governor.period_s;
  const double speed = config_.motors[index_].velocity_rad_s;
  safety::JointLimiter limiter({{.lower = start - std::abs(step_rad),
                                 .upper = start + std::abs(step_rad),
                                 .velocity = speed,
                                 .acceleration = speed * kAccelerationPerSpeed,
                                 .jerk = speed * kJerkPerSpeed,
                                 .margin = 0}},
                               period_s);
  limiter.reset(std::array{start});
  limiter.aim(std::array{start + step_rad});
  if (!is_held()) {
    told.was_let_go = true;
    return told;
  }
  std::vector<double> targets = measured.position;
  const auto period =
      std::chrono::duration_cast<devices::Duration>(std::chrono::duration<double>(period_s));
  {
    const Powered powered(device);
    devices::TimePoint due = clock_();
    // Once it is there it is given a moment to follow.
    int rest = static_cast<int>(std::ceil(0.3 / period_s));
    while (rest > 0) {
      due = std::max(due, clock_()) + period;
      if (!device.read(measured)) require(device);
      // As old as a loop may be late.
      if (clock_() - measured.time >
          std::max<devices::Duration>(3 * period, config_.governor.longest_gap))
        throw DeviceError("the motors do not tell where they are any more");
      if (std::isfinite(measured.current[index_]))
        told.largest_A = std::max(told.largest_A, std::abs(measured.current[index_]));
      if (!told.was_let_go && !limiter.atRest() && !is_held()) {
        told.was_let_go = true;
        limiter.brake();
      }
      targets[index_] = limiter.step()[0];
      if (!device.write(targets)) require(device);
      if (limiter.atRest()) --rest;
      sleep_until_(due);
    }
    device.read(measured);
    told.to = placeOf(measured.position[index_]);
    if (std::isnan(measured.current[index_]))
      told.largest_A = std::numeric_limits<double>::quiet_NaN();
  }
  return told;
}

}  // namespace handgraft::bringup
