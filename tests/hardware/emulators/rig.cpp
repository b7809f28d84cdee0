#include "tests/hardware/emulators/rig.h"

#include "hardware/devices/ability_hand_device.h"
#include "hardware/devices/dynamixel_hand.h"
#include "hardware/devices/examples/line_hand.h"
#include "hardware/devices/inspire_hand.h"

#include "tests/hardware/emulators/line_hand_emulator.h"
#include "tests/hardware/emulators/rig_parts.h"

namespace handgraft::test {

namespace {

using devices::Fault;
using devices::MotorScale;
using std::chrono::milliseconds;

namespace ah = protocols::ability_hand;
namespace dxl = protocols::dynamixel;

class DynamixelRig final : public Rig {
 public:
  explicit DynamixelRig(WireKind kind)
      : emulator_({3, 1, 7}),
        watchdog_(kind == WireKind::kVirtual ? 100 : 2500),
        wire_(makeWire(kind, emulator_, 4000000)),
        config_(makeConfig(kind, watchdog_)),
        hand_(config_, wire_->channel(), wire_->clock()) {}

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return config_.motors.size(); }

  double unit() const override { return dxl::kRadPerCount; }

  double lower(std::size_t i) const override { return config_.motors[i].scale.lower; }

  double upper(std::size_t i) const override { return config_.motors[i].scale.upper; }

  Duration watchdog() const override { return watchdog_; }

  Fault::Kind watchdogFault() const override { return Fault::Kind::kWatchdog; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return config_.motors[i].scale.angle(motor(i).servo.position);
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    bool is_powered = false;
    for (const auto& each : config_.motors) {
      is_powered = is_powered || (emulator_.get(each.id, "torque_enable") != 0 &&
                                  emulator_.get(each.id, "bus_watchdog") != 0xFF);
    }
    return is_powered;
  }

  void leaveStaleGoal() override {
    for (const auto& each : config_.motors)
      emulator_.set(each.id, "goal_position", 3500);
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    motor(1).is_broken = true;
    emulator_.fail(config_.motors[1].id, dxl::kOverload);
  }

  void heal() override {
    const auto lock = wire_->hold();
    motor(1).is_broken = false;
  }

 private:
  static devices::DynamixelConfig makeConfig(WireKind kind, milliseconds watchdog) {
    devices::DynamixelConfig config;
    const MotorScale forth{dxl::kRadPerCount, 2048.0, 1, -1.0, 1.2};
    const MotorScale back{dxl::kRadPerCount, 2000.0, -1, -0.5, 1.3};
    config.motors = {{3, forth}, {1, back}, {7, forth}};
    config.watchdog = watchdog;
    config.reply_timeout = replyTimeout(kind);
    return config;
  }

  DynamixelEmulator::Motor& motor(std::size_t i) {
    return emulator_.motor(config_.motors[i].id);
  }

  DynamixelEmulator emulator_;
  milliseconds watchdog_;
  std::unique_ptr<Wire> wire_;
  devices::DynamixelConfig config_;
  devices::DynamixelHand hand_;
};

class AbilityHandRig final : public Rig {
 public:
  explicit AbilityHandRig(WireKind kind)
      : wire_(makeWire(kind, emulator_, 460800)),
        config_(makeConfig(kind)),
        hand_(config_, wire_->channel(), wire_->clock()) {}

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return ah::kMotorCount; }

  double unit() const override { return ah::kRadPerCount; }

  double lower(std::size_t i) const override { return config_.lower[i]; }

  double upper(std::size_t i) const override { return config_.upper[i]; }

  Duration watchdog() const override { return milliseconds(300); }

  // The hand tells nothing; we know how long we were silent.
  Fault::Kind watchdogFault() const override { return Fault::Kind::kStarved; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return emulator_.servos[i].position * ah::kRadPerCount;
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return emulator_.is_in_api_mode;
  }

  void leaveStaleGoal() override {
    for (EmulatedServo& servo : emulator_.servos)
      servo.goal = 9000.0;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    emulator_.limited = 0x02;
  }

  void heal() override {
    const auto lock = wire_->hold();
    emulator_.limited = 0;
  }

 private:
  static devices::AbilityHandConfig makeConfig(WireKind kind) {
    devices::AbilityHandConfig config;
    config.reply_timeout = replyTimeout(kind);
    config.hot_patience = milliseconds(50);
    if (kind == WireKind::kPty) config.longest_gap = milliseconds(290);
    return config;
  }

  AbilityHandEmulator emulator_;
  std::unique_ptr<Wire> wire_;
  devices::AbilityHandConfig config_;
  devices::AbilityHandDevice hand_;
};

class InspireRig final : public Rig {
 public:
  explicit InspireRig(WireKind kind)
      : wire_(makeWire(kind, emulator_, 115200)),
        config_(makeConfig(kind)),
        hand_(config_, wire_->channel(), wire_->clock()) {}

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return config_.scales.size(); }

  double unit() const override { return config_.scales[0].rad_per_unit; }

  double lower(std::size_t i) const override { return config_.scales[i].lower; }

  double upper(std::size_t i) const override { return config_.scales[i].upper; }

  Duration watchdog() const override { return {}; }

  Fault::Kind watchdogFault() const override { return Fault::Kind::kNone; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return config_.scales[i].angle(emulator_.fingers[i].servo.position);
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return std::any_of(emulator_.fingers.begin(), emulator_.fingers.end(),
                       [](const auto& finger) {
                         return finger.speed > 0;
                       });
  }

  void leaveStaleGoal() override {
    for (auto& finger : emulator_.fingers)
      finger.set = 100;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    emulator_.fingers[1].is_broken = true;
    emulator_.fingers[1].error = protocols::inspire::kOverCurrent;
  }

  void heal() override {
    const auto lock = wire_->hold();
    emulator_.fingers[1].is_broken = false;
  }

 private:
  static devices::InspireConfig makeConfig(WireKind kind) {
    devices::InspireConfig config;
    config.scales.fill({1.5e-3, 1000.0, -1, 0.0, 1.5});
    config.reply_timeout = replyTimeout(kind);
    return config;
  }

  InspireEmulator emulator_;
  std::unique_ptr<Wire> wire_;
  devices::InspireConfig config_;
  devices::InspireHand hand_;
};

class LineRig final : public Rig {
 public:
  explicit LineRig(WireKind kind)
      : wire_(makeWire(kind, emulator_, 115200)),
        config_(makeConfig(kind)),
        hand_(config_, wire_->channel(), wire_->clock()) {
    if (kind == WireKind::kPty) emulator_.watchdog = milliseconds(2500);
  }

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return config_.scales.size(); }

  double unit() const override { return kUnit; }

  double lower(std::size_t i) const override { return config_.scales[i].lower; }

  double upper(std::size_t i) const override { return config_.scales[i].upper; }

  Duration watchdog() const override { return emulator_.watchdog; }

  Fault::Kind watchdogFault() const override { return Fault::Kind::kWatchdog; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return config_.scales[i].angle(emulator_.servos[i].position);
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return emulator_.state == devices::LineState::kOn;
  }

  void leaveStaleGoal() override {
    for (EmulatedServo& servo : emulator_.servos)
      servo.goal = 9000;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    emulator_.broken_motor = 1;
  }

  void heal() override {
    const auto lock = wire_->hold();
    emulator_.broken_motor = -1;
  }

 private:
  static constexpr double kUnit = 1e-4;

  static devices::LineHandConfig makeConfig(WireKind kind) {
    devices::LineHandConfig config;
    config.scales = {
        {{kUnit, 0, 1, -0.2, 1.6}, {kUnit, 5000, -1, -0.3, 1.1}, {kUnit, 0, 1, 0, 1}}};
    config.reply_timeout = replyTimeout(kind);
    if (kind == WireKind::kPty) config.watchdog = milliseconds(2500);
    return config;
  }

  LineHandEmulator emulator_;
  std::unique_ptr<Wire> wire_;
  devices::LineHandConfig config_;
  devices::LineHand hand_;
};

}  // namespace

std::vector<double> Rig::angles() {
  std::vector<double> all;
  for (std::size_t i = 0; i < count(); ++i)
    all.push_back(angle(i));
  return all;
}

std::vector<double> Rig::between(double share) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < count(); ++i)
    all.push_back(lower(i) + share * (upper(i) - lower(i)));
  return all;
}

std::unique_ptr<Rig> makeRig(RigKind kind, WireKind wire) {
  switch (kind) {
    case RigKind::kDynamixel:
      return std::make_unique<DynamixelRig>(wire);
    case RigKind::kAbilityHand:
      return std::make_unique<AbilityHandRig>(wire);
    case RigKind::kODrive06:
      return makeODriveRig(wire, protocols::odrive::Firmware::k06);
    case RigKind::kODrive05:
      return makeODriveRig(wire, protocols::odrive::Firmware::k05);
    case RigKind::kInspire:
      return std::make_unique<InspireRig>(wire);
    case RigKind::kAllegro:
      return makeAllegroRig(wire);
    case RigKind::kLines:
      return std::make_unique<LineRig>(wire);
  }
  return nullptr;
}

std::string nameOf(RigKind kind) {
  switch (kind) {
    case RigKind::kDynamixel:
      return "Dynamixel";
    case RigKind::kAbilityHand:
      return "AbilityHand";
    case RigKind::kODrive06:
      return "ODrive06";
    case RigKind::kODrive05:
      return "ODrive05";
    case RigKind::kInspire:
      return "Inspire";
    case RigKind::kAllegro:
      return "Allegro";
    case RigKind::kLines:
      return "Lines";
  }
  return "";
}

}  // namespace handgraft::test
