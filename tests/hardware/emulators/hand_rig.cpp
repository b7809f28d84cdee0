#include "tests/hardware/emulators/hand_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace handgraft::test {

namespace {

using config::DeviceKind;
using config::HandConfig;
using config::MotorConfig;

namespace ah = protocols::ability_hand;
namespace dxl = protocols::dynamixel;
namespace odrive = protocols::odrive;

constexpr double kTurn = 2 * std::numbers::pi;

std::unique_ptr<Wire> makeWire(EmulatedDevice& device, const HandConfig& config, bool on_pty) {
  if (!on_pty) return makeVirtualWire(device);
  using config::DeviceKind;
  const bool is_can =
      config.device.kind == DeviceKind::kODrive || config.device.kind == DeviceKind::kAllegro;
  const bool is_usb = is_can && !config.device.is_baud_told;
  return makePty(device, config.device.baud, is_usb ? Line::kUsb : Line::kUart);
}

/// The motor's angle, of its device's at the encoder.
double angleOf(const MotorConfig& motor, double encoder_rad) {
  return motor.direction * (encoder_rad - motor.zero_rad) / motor.gear;
}

double encoderOf(const MotorConfig& motor, double angle_rad) {
  return motor.zero_rad + motor.direction * motor.gear * angle_rad;
}

class DynamixelHandRig final : public HandRig {
 public:
  DynamixelHandRig(const HandConfig& config, bool on_pty)
      : config_(config), emulator_(idsOf(config)), wire_(makeWire(emulator_, config, on_pty)) {}

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], servo(i).position * dxl::kRadPerCount);
  }

  double goal(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], servo(i).goal * dxl::kRadPerCount);
  }

  double unit(std::size_t i) const override {
    return dxl::kRadPerCount / config_.motors[i].gear;
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    for (const std::uint8_t id : idsOf(config_)) {
      if (emulator_.get(id, "torque_enable") != 0 && emulator_.get(id, "bus_watchdog") != 0xFF)
        return true;
    }
    return false;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    emulator_.motor(breakable()).is_broken = true;
    emulator_.fail(breakable(), dxl::kOverload);
  }

  void heal() override {
    const auto lock = wire_->hold();
    emulator_.motor(breakable()).is_broken = false;
  }

 protected:
  void turn(std::size_t i, double angle_rad) override {
    const auto lock = wire_->hold();
    servo(i).position = encoderOf(config_.motors[i], angle_rad) / dxl::kRadPerCount;
  }

 private:
  static std::vector<std::uint8_t> idsOf(const HandConfig& config) {
    std::vector<std::uint8_t> ids;
    for (const MotorConfig& motor : config.motors)
      ids.push_back(static_cast<std::uint8_t>(motor.id));
    return ids;
  }

  /// The second one, if there is one.
  [[nodiscard]] std::uint8_t breakable() const {
    const std::vector<std::uint8_t> ids = idsOf(config_);
    return ids[std::min<std::size_t>(1, ids.size() - 1)];
  }

  EmulatedServo& servo(std::size_t i) {
    return emulator_.motor(static_cast<std::uint8_t>(config_.motors[i].id)).servo;
  }

  HandConfig config_;
  DynamixelEmulator emulator_;
  std::unique_ptr<Wire> wire_;
};

class AbilityHandHandRig final : public HandRig {
 public:
  AbilityHandHandRig(const HandConfig& config, bool on_pty)
      : wire_(makeWire(emulator_, config, on_pty)) {}

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return emulator_.servos[i].position * ah::kRadPerCount;
  }

  double goal(std::size_t i) override {
    const auto lock = wire_->hold();
    return emulator_.servos[i].goal * ah::kRadPerCount;
  }

  double unit(std::size_t /*i*/) const override { return ah::kRadPerCount; }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return emulator_.is_in_api_mode;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    emulator_.limited = 0x02;
  }

  void heal() override {
    const auto lock = wire_->hold();
    emulator_.limited = 0;
  }

 protected:
  void turn(std::size_t i, double angle_rad) override {
    const auto lock = wire_->hold();
    emulator_.servos[i].position = angle_rad / ah::kRadPerCount;
  }

 private:
  AbilityHandEmulator emulator_;
  std::unique_ptr<Wire> wire_;
};

class InspireHandRig final : public HandRig {
 public:
  InspireHandRig(const HandConfig& config, bool on_pty)
      : config_(config), wire_(makeWire(emulator_, config, on_pty)) {}

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], kUnit * finger(i).servo.position);
  }

  double goal(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], kUnit * finger(i).set);
  }

  double unit(std::size_t i) const override { return kUnit / config_.motors[i].gear; }

  bool isPowered() override {
    const auto lock = wire_->hold();
    for (const auto& each : emulator_.fingers) {
      if (each.speed > 0) return true;
    }
    return false;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    finger(1).is_broken = true;
    finger(1).error = protocols::inspire::kOverCurrent;
  }

  void heal() override {
    const auto lock = wire_->hold();
    finger(1).is_broken = false;
  }

 protected:
  void turn(std::size_t i, double angle_rad) override {
    const auto lock = wire_->hold();
    finger(i).servo.position = encoderOf(config_.motors[i], angle_rad) / kUnit;
  }

 private:
  static constexpr double kUnit = 1e-3;

  InspireEmulator::Finger& finger(std::size_t i) {
    return emulator_.fingers[static_cast<std::size_t>(config_.motors[i].id)];
  }

  HandConfig config_;
  InspireEmulator emulator_;
  std::unique_ptr<Wire> wire_;
};

class AllegroHandRig final : public HandRig {
 public:
  AllegroHandRig(const HandConfig& config, bool on_pty)
      : config_(config), emulator_(bus_), wire_(makeWire(emulator_, config, on_pty)) {
    // Each joint somewhere inside its range.
    const auto lock = wire_->hold();
    for (const MotorConfig& motor : config.motors) {
      const double angle =
          motor.range_rad.lower + 0.3 * (motor.range_rad.upper - motor.range_rad.lower);
      const double encoder = motor.zero_rad + motor.direction * motor.gear * angle;
      joint(motor).counts = std::round(encoder / protocols::allegro::kRadPerCount);
    }
  }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    const MotorConfig& motor = config_.motors[i];
    return angleOf(motor, joint(motor).counts * protocols::allegro::kRadPerCount);
  }

  // It is told torques: where they lead to, by the stiffness that they were made with.
  double goal(std::size_t i) override {
    const double here = angle(i);
    const auto lock = wire_->hold();
    const MotorConfig& motor = config_.motors[i];
    const double torque = motor.direction * joint(motor).pwm / protocols::allegro::kPwmPerNm;
    return here + torque / config_.device.stiffness;
  }

  double unit(std::size_t /*i*/) const override {
    return 0.5 / protocols::allegro::kPwmPerNm / config_.device.stiffness +
           2 * protocols::allegro::kRadPerCount;
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return bus_.is_on;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    bus_.is_broken = true;
  }

  void heal() override {
    const auto lock = wire_->hold();
    bus_.is_broken = false;
  }

  AllegroEmulator& bus() { return bus_; }

 protected:
  void turn(std::size_t i, double angle_rad) override {
    const auto lock = wire_->hold();
    const MotorConfig& motor = config_.motors[i];
    joint(motor).counts = encoderOf(motor, angle_rad) / protocols::allegro::kRadPerCount;
  }

 private:
  AllegroEmulator::Joint& joint(const MotorConfig& motor) {
    return bus_.joints[static_cast<std::size_t>(motor.id)];
  }

  HandConfig config_;
  AllegroEmulator bus_;
  SlcanEmulator emulator_;
  std::unique_ptr<Wire> wire_;
};

class ODriveHandRig final : public HandRig {
 public:
  ODriveHandRig(const HandConfig& config, bool on_pty, Duration watchdog)
      : config_(config),
        bus_(nodesOf(config),
             config.device.firmware == config::ODriveFirmware::k05 ? odrive::Firmware::k05
                                                                   : odrive::Firmware::k06),
        emulator_(bus_),
        wire_(makeWire(emulator_, config, on_pty)) {
    const auto lock = wire_->hold();
    for (const int node : nodesOf(config)) {
      bus_.axis(node).watchdog =
          watchdog > Duration::zero() ? watchdog : config.device.watchdog;
    }
  }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], axis(i).servo.position * kTurn);
  }

  double goal(std::size_t i) override {
    const auto lock = wire_->hold();
    return angleOf(config_.motors[i], axis(i).servo.goal * kTurn);
  }

  double unit(std::size_t /*i*/) const override { return 4e-6; }

  bool isPowered() override {
    const auto lock = wire_->hold();
    for (std::size_t i = 0; i < config_.motors.size(); ++i) {
      if (axis(i).state == odrive::AxisState::kClosedLoop) return true;
    }
    return false;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    axis(1).is_broken = true;
    ODriveEmulator::fail(axis(1), 0x2000);
  }

  void heal() override {
    const auto lock = wire_->hold();
    axis(1).is_broken = false;
  }

  ODriveEmulator& bus() { return bus_; }

 protected:
  void turn(std::size_t i, double angle_rad) override {
    const auto lock = wire_->hold();
    axis(i).servo.position = encoderOf(config_.motors[i], angle_rad) / kTurn;
  }

 private:
  static std::vector<int> nodesOf(const HandConfig& config) {
    std::vector<int> nodes;
    for (const MotorConfig& motor : config.motors)
      nodes.push_back(motor.id);
    return nodes;
  }

  ODriveEmulator::Axis& axis(std::size_t i) { return bus_.axis(config_.motors[i].id); }

  HandConfig config_;
  ODriveEmulator bus_;
  SlcanEmulator emulator_;
  std::unique_ptr<Wire> wire_;
};

}  // namespace

std::unique_ptr<HandRig> makeHandRig(const HandConfig& config,
                                     bool on_a_pty,
                                     Duration watchdog) {
  switch (config.device.kind) {
    case DeviceKind::kDynamixel:
      return std::make_unique<DynamixelHandRig>(config, on_a_pty);
    case DeviceKind::kAbilityHand:
      return std::make_unique<AbilityHandHandRig>(config, on_a_pty);
    case DeviceKind::kODrive:
      return std::make_unique<ODriveHandRig>(config, on_a_pty, watchdog);
    case DeviceKind::kInspire:
      return std::make_unique<InspireHandRig>(config, on_a_pty);
    case DeviceKind::kAllegro:
      return std::make_unique<AllegroHandRig>(config, on_a_pty);
    case DeviceKind::kSimulated:
      break;
  }
  throw std::runtime_error("a simulated hand needs no emulator");
}

std::vector<double> slackenLines(HandRig& odrive_rig, const HandConfig& config) {
  const auto lock = odrive_rig.wire().hold();
  std::vector<double> zeros_rad;
  double slack_rev = 0.2;
  for (const MotorConfig& motor : config.motors) {
    ODriveEmulator::Axis& axis = busOf(odrive_rig).axis(motor.id);
    axis.winds = motor.direction;
    axis.taut = axis.servo.position + motor.direction * slack_rev;
    zeros_rad.push_back(*axis.taut * kTurn);
    slack_rev += 0.15;
  }
  return zeros_rad;
}

std::vector<double> zerosOfShafts(HandRig& odrive_rig, const config::HandConfig& homed) {
  const auto lock = odrive_rig.wire().hold();
  std::vector<double> zeros_rad;
  for (const MotorConfig& motor : homed.motors) {
    const double from = busOf(odrive_rig).axis(motor.id).counts_from;
    zeros_rad.push_back(motor.zero_rad - kTurn * from);
  }
  return zeros_rad;
}

AllegroEmulator& allegroOf(HandRig& allegro_rig) {
  return dynamic_cast<AllegroHandRig&>(allegro_rig).bus();
}

ODriveEmulator& busOf(HandRig& odrive_rig) {
  return dynamic_cast<ODriveHandRig&>(odrive_rig).bus();
}

}  // namespace handgraft::test
