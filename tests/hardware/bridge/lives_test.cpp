// Random lives of a hand, in virtual time: power cycles of device and bridge at any moment, the
// server gone, the cable out, homing interrupted, calibration files that are old, torn, or
// another hand's. Whatever happens: nothing moves without an ARM or a HOME, no motor is sent
// beyond its range as it truly is, none is sent faster than it may go.
//
// An Allegro Hand is told torques: where it goes, and how fast, is looked at. It has no
// watchdog: whoever kills its bridge or pulls its cable switches its power off, as its config
// has accepted.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "hardware/config/calibration_file.h"

#include "tests/hardware/bridge/hand_in_motion.h"
#include "tests/hardware/config/config_texts.h"

namespace handgraft::bridge {
namespace {

using handgraft::test::HandRig;
using safety::GovernorState;
using std::chrono::milliseconds;

// A quarter of them with each change; `./dev check` lives all.
const int lives_lived = environment("HANDGRAFT_ALL_LIVES").empty() ? 250 : 1000;
constexpr int kEvents = 12;  // of a life
constexpr double kTurn = 2 * std::numbers::pi;

/// What happened in all lives, and what must not have.
struct Tally {
  long turns = 0, armed = 0, homed = 0, power_cycles = 0, kills = 0, cables = 0, servers = 0;
  long refused_files = 0, voided = 0, faults = 0;
  long moved_unasked = 0, beyond = 0, too_fast = 0;
  double farthest_rad = 0;
};

class Life {
 public:
  Life(const config::HandConfig& config, std::uint64_t seed, Tally& tally)
      : config_(config),
        rig_(handgraft::test::makeHandRig(config)),
        random_(seed),
        tally_(tally),
        period_(std::chrono::duration_cast<devices::Duration>(
            std::chrono::duration<double>(config.governor.period_s))),
        zeros_rad_(config.motors.size(), 0.0) {
    if (config_.homing.empty()) {
      file_ = old_file_ = config::calibrationText(config_);  // as `check` leaves it
    } else {
      zeros_rad_ = handgraft::test::slackenLines(*rig_, config_);
    }
    // What is allowed in a period, beside a unit: a start that fades comes on top.
    for (const config::MotorConfig& motor : config_.motors)
      way_rad_.push_back(1.6 * motor.velocity_rad_s * config_.governor.period_s + 1e-3);
    pass(0.2);
    startBridge();
  }

  void live() {
    for (int event = 0; event < kEvents; ++event) {
      happen();
      turnFor(between(0.02, 0.6));
    }
    if (motion_) kill();
    pass(0.6);
    watchStillness(0.3);
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  int choose(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  devices::TimePoint now() { return rig_->wire().clock()(); }

  void pass(double seconds) {
    rig_->wire().pass(
        std::chrono::duration_cast<devices::Duration>(std::chrono::duration<double>(seconds)));
  }

  /// As the hand truly is, from its true zeros.
  double angle(std::size_t i) {
    const config::MotorConfig& motor = config_.motors[i];
    return rig_->angle(i) - motor.direction * zeros_rad_[i] / motor.gear;
  }

  double goal(std::size_t i) {
    if (isTorqueDriven()) return angle(i);
    const config::MotorConfig& motor = config_.motors[i];
    return rig_->goal(i) - motor.direction * zeros_rad_[i] / motor.gear;
  }

  [[nodiscard]] bool isTorqueDriven() const {
    return config_.device.kind == config::DeviceKind::kAllegro;
  }

  void switchPowerOff() {
    const auto lock = rig_->wire().hold();
    handgraft::test::allegroOf(*rig_).switchOff();
  }

  // === The bridge's own life

  void startBridge() {
    config::HandConfig config = config_;
    config.calibration = "a file";
    const int kind = choose(8);
    std::optional<std::string> file = file_;
    if (kind == 5) file = old_file_;
    if (kind == 6 && file) file = file->substr(0, file->size() / 2);
    if (kind == 7 && file) file->replace(file->find("hand: "), 7, "hand: x");
    try {
      if (file) {
        config::parseCalibration(*file, config);
        config.is_calibrated = true;
      }
    } catch (const InvalidInput&) {
      ++tally_.refused_files;
      return;  // it does not start; somebody looks into it
    }
    auto keep = [this](const config::HandConfig* homed) {
      if (file_) old_file_ = file_;
      file_ = homed != nullptr ? std::optional(config::calibrationText(*homed)) : std::nullopt;
      if (homed != nullptr) ++tally_.homed;
    };
    motion_ = std::make_unique<Motion>(
        config,
        [this](const config::HandConfig& asked) {
          return makeDeviceOn(rig_->wire().channel(), asked, rig_->wire().clock());
        },
        rig_->wire().clock(), keep);
    is_asked_ = false;
    ++stream_;
  }

  /// As by SIGKILL: nothing more is sent, nothing is said.
  void kill() {
    ++tally_.kills;
    // Its destructor would switch the motors off.
    rig_->wire().unplug();
    motion_.reset();
    if (isTorqueDriven()) switchPowerOff();
    if (is_plugged_) rig_->wire().plug();
    is_asked_ = false;
    goals_.clear();
  }

  // === What happens

  void happen() {
    switch (choose(12)) {
      case 0:
      case 1:
      case 2:
        return act(Request::kArm);
      case 3:
        if (!config_.homing.empty()) return home();
        return act(Request::kArm);
      case 4:
        return act(choose(2) == 0 ? Request::kDisarm : Request::kReset);
      case 5:
        return act(Request::kReset);
      case 6:
        if (motion_) motion_->estop();
        return;
      case 7:
        return cyclePower();
      case 8:
        if (motion_) {
          kill();
          pass(between(0, 0.6));
        }
        return startBridge();
      case 9:
        ++tally_.cables;
        if (is_plugged_) {
          rig_->wire().unplug();
          if (isTorqueDriven()) switchPowerOff();
        } else {
          rig_->wire().plug();
        }
        is_plugged_ = !is_plugged_;
        return;
      case 10:
        ++tally_.servers;
        is_streaming_ = !is_streaming_;
        return;
      default:
        return offer();
    }
  }

  void act(Request request) {
    if (!motion_) return startBridge();
    if (request == Request::kArm) {
      is_streaming_ = true;
      offer();
    }
    motion_->request(request);
    is_asked_ = is_asked_ || request == Request::kArm;
  }

  void home() {
    if (!motion_) return;
    motion_->request(Request::kHome);
    is_asked_ = true;
    // Often to its end, sometimes not.
    for (int k = 0; k < 4000 && motion_ && choose(3000) != 0; ++k) {
      turn();
      if (!motion_->state().is_homing) break;
    }
  }

  void offer() {
    if (!motion_) return;
    StreamPose pose;
    pose.stream = stream_;
    pose.sequence = ++sequence_;
    pose.arrived = now();
    pose.names = config_.governor.names;
    for (const safety::JointLimits& limits : config_.governor.limits)
      pose.joint_rad.push_back(limits.lower +
                               between(-0.3, 1.3) * (limits.upper - limits.lower));
    motion_->offer(pose);
  }

  void cyclePower() {
    ++tally_.power_cycles;
    goals_.clear();  // what an axis forgets is no order of ours
    using config::DeviceKind;
    const auto lock = rig_->wire().hold();
    handgraft::test::EmulatedDevice& device = rig_->emulated();
    switch (config_.device.kind) {
      case DeviceKind::kODrive:
        for (const config::MotorConfig& motor : config_.motors) {
          if (choose(2) == 0) busOf(*rig_).restart(motor.id);
        }
        return;
      case DeviceKind::kDynamixel:
        dynamic_cast<handgraft::test::DynamixelEmulator&>(device).powerCycle();
        return;
      case DeviceKind::kAbilityHand:
        dynamic_cast<handgraft::test::AbilityHandEmulator&>(device).is_in_api_mode = false;
        return;
      case DeviceKind::kInspire:
        for (auto& finger : dynamic_cast<handgraft::test::InspireEmulator&>(device).fingers) {
          finger.set = static_cast<std::uint16_t>(std::lround(finger.servo.position));
          finger.speed = 1000;  // as it comes from the factory
        }
        return;
      case DeviceKind::kAllegro:
        handgraft::test::allegroOf(*rig_).switchOff();
        return;
      case DeviceKind::kSimulated:
        return;
    }
  }

  // === What is watched

  void turn() {
    ++tally_.turns;
    const devices::TimePoint due = now() + period_;
    const std::vector<double> before = angles();
    if (motion_) {
      if (is_streaming_) motion_->renew(stream_, now());
      motion_->turn();
      watchGoals();
    }
    if (now() < due) rig_->wire().pass(due - now());
    // A device that lost its bridge, or its wire, goes on until its own watchdog ends that.
    const bool may_move = is_asked_ || now() < quiet_at_;
    for (std::size_t i = 0; !may_move && i < before.size(); ++i)
      tally_.moved_unasked += std::abs(rig_->angle(i) - before[i]) > 1e-9 ? 1 : 0;
    if (!motion_) return;
    const MotionState& state = motion_->state();
    tally_.armed += state.state == GovernorState::kArmed ? 1 : 0;
    if (state.state == GovernorState::kFault && !was_fault_) ++tally_.faults;
    was_fault_ = state.state == GovernorState::kFault;
    if (was_homed_ && !state.is_homed && !state.is_homing) ++tally_.voided;
    was_homed_ = state.is_homed;
    const bool is_over = !state.is_powered && !state.is_homing &&
                         state.state != GovernorState::kArmed &&
                         state.state != GovernorState::kHolding;
    if (is_over && is_asked_) {
      is_asked_ = false;
      quiet_at_ = now() + watchdog();
    }
  }

  devices::Duration watchdog() const { return config_.device.watchdog + milliseconds(60); }

  // What the device decodes, while the governor leads it.
  void watchGoals() {
    const MotionState& state = motion_->state();
    if (!state.is_powered || state.is_homing || !is_plugged_ || !rig_->isPowered()) {
      goals_.clear();
      return;
    }
    std::vector<double> now_rad;
    for (std::size_t i = 0; i < config_.motors.size(); ++i)
      now_rad.push_back(goal(i));
    for (std::size_t i = 0; !goals_.empty() && i < now_rad.size(); ++i) {
      const config::MotorConfig& motor = config_.motors[i];
      // A hand may stand outside by what is let pass as measured, and start there.
      const double slack = config_.motor_outside_rad + 0.05;
      const double off =
          std::max(motor.range_rad.lower - now_rad[i], now_rad[i] - motor.range_rad.upper);
      tally_.farthest_rad = std::max(tally_.farthest_rad, off);
      tally_.beyond += off > slack ? 1 : 0;
      tally_.too_fast += std::abs(now_rad[i] - goals_[i]) > way_rad_[i] + rig_->unit(i) ? 1 : 0;
    }
    goals_ = now_rad;
  }

  std::vector<double> angles() {
    std::vector<double> all;
    for (std::size_t i = 0; i < config_.motors.size(); ++i)
      all.push_back(rig_->angle(i));
    return all;
  }

  void turnFor(double seconds) {
    const devices::TimePoint end = now() + std::chrono::duration_cast<devices::Duration>(
                                               std::chrono::duration<double>(seconds));
    while (now() < end)
      turn();
  }

  void watchStillness(double seconds) {
    const std::vector<double> before = angles();
    pass(seconds);
    for (std::size_t i = 0; i < before.size(); ++i)
      tally_.moved_unasked += std::abs(rig_->angle(i) - before[i]) > 1e-9 ? 1 : 0;
  }

  config::HandConfig config_;
  std::unique_ptr<HandRig> rig_;
  std::mt19937_64 random_;
  Tally& tally_;
  devices::Duration period_;
  std::vector<double> zeros_rad_, way_rad_, goals_;
  std::unique_ptr<Motion> motion_;
  std::optional<std::string> file_, old_file_;
  std::uint64_t stream_ = 0, sequence_ = 0;
  bool is_plugged_ = true, is_streaming_ = true;
  bool is_asked_ = false;  // ARM or HOME, and not over yet
  bool was_fault_ = false, was_homed_ = false;
  devices::TimePoint quiet_at_{};
};

class RandomLives : public ::testing::TestWithParam<std::string> {};

TEST_P(RandomLives, MoveNothingUnaskedNothingBeyondItsRangeAndNothingTooFast) {
  config::HandConfig config = test::exampleConfig(GetParam());
  for (safety::HomingStep& step : config.homing)
    step.travel_rad = 4;  // not far, so that lives are short
  if (config.device.kind == config::DeviceKind::kAllegro) {
    config.device.torque = 0.9;       // strong enough to go faster than it may
    config.governor.period_s = 0.01;  // an emulated joint is slow, and so are lives at 333 Hz
  }
  Tally tally;
  for (int life = 0; life < lives_lived; ++life)
    Life(config, 20260000U + static_cast<unsigned>(life), tally).live();
  std::cout << fmt::format(
      "{}: {} lives, {} turns, {} armed, {} homings, {} power cycles, {} kills, {} cables, {} "
      "servers gone or back, {} files refused, {} zeros voided, {} faults: {} moved unasked, "
      "{} "
      "beyond their range (farthest {:.3f} rad), {} too fast\n",
      GetParam(), lives_lived, tally.turns, tally.armed, tally.homed, tally.power_cycles,
      tally.kills, tally.cables, tally.servers, tally.refused_files, tally.voided, tally.faults,
      tally.moved_unasked, tally.beyond, tally.farthest_rad, tally.too_fast);
  EXPECT_EQ(tally.moved_unasked, 0);
  EXPECT_EQ(tally.beyond, 0);
  EXPECT_EQ(tally.too_fast, 0);
  EXPECT_GT(tally.armed, lives_lived) << "they have to live";
  EXPECT_GT(tally.refused_files, 0);
  if (!config.homing.empty()) {
    EXPECT_GT(tally.homed, lives_lived / 20);
    EXPECT_GT(tally.voided, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols,
                         RandomLives,
                         ::testing::ValuesIn(config::texts::example_configs),
                         [](const auto& told) {
                           return told.param;
                         });

}  // namespace
}  // namespace handgraft::bridge
