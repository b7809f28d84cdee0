// Hands on a CAN bus.
#include "hardware/devices/allegro_hand.h"
#include "hardware/devices/odrive_hand.h"
#include "hardware/devices/slcan_channel.h"

#include "tests/hardware/emulators/rig_parts.h"

namespace handgraft::test {

namespace {

using devices::Fault;
using devices::MotorScale;
using std::chrono::milliseconds;

namespace odrive = protocols::odrive;

class ODriveRig final : public Rig {
 public:
  ODriveRig(WireKind kind, odrive::Firmware firmware)
      : bus_({0, 5, 9}, firmware),
        emulator_(bus_),
        wire_(makeWire(kind, emulator_, 2000000)),
        config_(makeConfig(kind, firmware)),
        can_(wire_->channel(), 500000, wire_->clock()),
        hand_(config_, can_, wire_->clock()) {
    if (kind == WireKind::kVirtual) return;
    const auto lock = wire_->hold();
    for (const auto& axis : config_.axes)
      bus_.axis(axis.node).watchdog = std::chrono::milliseconds(2500);
  }

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return config_.axes.size(); }

  double unit() const override { return 4e-6; }  // a float of a few turns, in rad

  double lower(std::size_t i) const override { return config_.axes[i].scale.lower; }

  double upper(std::size_t i) const override { return config_.axes[i].scale.upper; }

  Duration watchdog() const override { return bus_watchdog_; }

  std::size_t stopMessages() const override { return count(); }

  Fault::Kind watchdogFault() const override { return Fault::Kind::kWatchdog; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return config_.axes[i].scale.angle(axis(i).servo.position);
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    bool is_powered = false;
    for (std::size_t i = 0; i < count(); ++i)
      is_powered = is_powered || axis(i).state == odrive::AxisState::kClosedLoop;
    return is_powered;
  }

  void leaveStaleGoal() override {
    for (std::size_t i = 0; i < count(); ++i)
      axis(i).servo.goal = 7.0;
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

 private:
  static devices::ODriveConfig makeConfig(WireKind kind, odrive::Firmware firmware) {
    devices::ODriveConfig config;
    const double turn = 2.0 * std::numbers::pi;
    config.axes = {{0, {turn, 0.0, 1, -2.0, 10.1}},
                   {5, {turn, 0.3, -1, -1.0, 9.3}},
                   {9, {turn / 2.0, 0.1, 1, -1.7, 5.2}}};
    config.firmware = firmware;
    config.reply_timeout = replyTimeout(kind);
    if (kind == WireKind::kPty) config.watchdog = std::chrono::milliseconds(2500);
    if (kind == WireKind::kPty) config.heartbeat_timeout = std::chrono::seconds(10);
    if (kind == WireKind::kPty) config.state_timeout = std::chrono::seconds(20);
    return config;
  }

  ODriveEmulator::Axis& axis(std::size_t i) { return bus_.axis(config_.axes[i].node); }

  ODriveEmulator bus_;
  SlcanEmulator emulator_;
  std::unique_ptr<Wire> wire_;
  devices::ODriveConfig config_;
  devices::SlcanChannel can_;
  devices::ODriveHand hand_;
  Duration bus_watchdog_ = milliseconds(200);
};

class AllegroRig final : public Rig {
 public:
  explicit AllegroRig(WireKind kind)
      : emulator_(bus_),
        wire_(makeWire(kind, emulator_, 2000000)),
        config_(makeConfig(kind)),
        can_(wire_->channel(), 1000000, wire_->clock()),
        hand_(config_, can_, wire_->clock()) {}

  devices::Device& device() override { return hand_; }

  EmulatedDevice& emulated() override { return emulator_; }

  Wire& wire() override { return *wire_; }

  std::size_t count() const override { return config_.scales.size(); }

  // A torque below half of its unit moves nothing: what our own position loop leaves.
  double unit() const override { return 1e-3; }

  double lower(std::size_t i) const override { return config_.scales[i].lower; }

  double upper(std::size_t i) const override { return config_.scales[i].upper; }

  Duration watchdog() const override { return {}; }

  Fault::Kind watchdogFault() const override { return Fault::Kind::kNone; }

  double angle(std::size_t i) override {
    const auto lock = wire_->hold();
    return config_.scales[i].angle(bus_.joints[i].counts);
  }

  bool isPowered() override {
    const auto lock = wire_->hold();
    return bus_.is_on;
  }

  void leaveStaleGoal() override {
    for (auto& joint : bus_.joints)
      joint.pwm = 300;
  }

  void breakDown() override {
    const auto lock = wire_->hold();
    bus_.is_broken = true;
  }

  void heal() override {
    const auto lock = wire_->hold();
    bus_.is_broken = false;
  }

 private:
  static devices::AllegroConfig makeConfig(WireKind kind) {
    devices::AllegroConfig config;
    const double unit = protocols::allegro::kRadPerCount;
    for (std::size_t i = 0; i < config.scales.size(); ++i)
      config.scales[i] = {unit, i % 2 == 0 ? 100.0 : 6000.0, i % 2 == 0 ? 1 : -1, -0.2, 1.4};
    config.stiffness = 1.5;
    config.damping = 0.0;
    config.reply_timeout = replyTimeout(kind);
    return config;
  }

  AllegroEmulator bus_;
  SlcanEmulator emulator_;
  std::unique_ptr<Wire> wire_;
  devices::AllegroConfig config_;
  devices::SlcanChannel can_;
  devices::AllegroHand hand_;
};

}  // namespace

std::unique_ptr<Rig> makeODriveRig(WireKind wire, odrive::Firmware firmware) {
  return std::make_unique<ODriveRig>(wire, firmware);
}

std::unique_ptr<Rig> makeAllegroRig(WireKind wire) {
  return std::make_unique<AllegroRig>(wire);
}

}  // namespace handgraft::test
