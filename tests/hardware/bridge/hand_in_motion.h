#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bridge/device_factory.h"
#include "hardware/bridge/motion.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/emulators/hand_rig.h"
#include "tests/support/shared_data.h"

namespace handgraft::bridge::test {

using handgraft::test::HandRig;
using handgraft::test::makeHandRig;

inline config::HandConfig exampleConfig(const std::string& name) {
  config::HandConfig config =
      config::readHandConfig(handgraft::test::sourceDirectory() / "hardware" / "config" /
                             "examples" / (name + ".yaml"));
  config.device.carrier = config::CanCarrier::kSlcan;  // as emulated adapters speak
  return config;
}

/// An emulated hand in motion, a period at a time, in a time of its own, with a stream that
/// lives until it is told to die.
class HandInMotion {
 public:
  explicit HandInMotion(const config::HandConfig& config, Motion::OnHomed on_homed = {})
      : rig_(makeHandRig(config)),
        clock_(rig_->wire().clock()),
        period_(std::chrono::duration_cast<devices::Duration>(
            std::chrono::duration<double>(config.governor.period_s))),
        motion_(
            config,
            [this](const config::HandConfig& asked) {
              if (before_making) before_making(asked);
              DeviceStack stack = makeDeviceOn(rig_->wire().channel(), asked, clock_);
              stack.device->stopWhen([this] {
                return stop_asked_at && clock_() >= *stop_asked_at;
              });
              return stack;
            },
            clock_,
            std::move(on_homed)) {
    rig_->wire().pass(std::chrono::milliseconds(150));  // it has been on for a while
  }

  Motion& motion() { return motion_; }

  HandRig& rig() { return *rig_; }

  [[nodiscard]] const MotionState& state() const { return motion_.state(); }

  /// One period, as the bridge's loop does it.
  void turn() {
    const devices::TimePoint due = clock_() + period_;
    if (is_streaming) motion_.renew(stream, clock_());
    motion_.turn();
    if (clock_() < due) rig_->wire().pass(due - clock_());
  }

  void turnFor(double seconds) {
    const devices::TimePoint end = clock_() + std::chrono::duration_cast<devices::Duration>(
                                                  std::chrono::duration<double>(seconds));
    while (clock_() < end)
      turn();
  }

  /// False if that state does not come within `seconds`.
  bool turnUntil(safety::GovernorState wanted, double seconds = 10) {
    const devices::TimePoint end = clock_() + std::chrono::duration_cast<devices::Duration>(
                                                  std::chrono::duration<double>(seconds));
    while (state().state != wanted && clock_() < end)
      turn();
    return state().state == wanted;
  }

  /// A pose of the stream, each joint at a share of its range.
  void offer(double share) {
    std::vector<double> joint_rad;
    for (const safety::JointLimits& limits : motion_.config().governor.limits)
      joint_rad.push_back(limits.lower + share * (limits.upper - limits.lower));
    offer(std::move(joint_rad));
    motion_.renew(stream, clock_());
  }

  /// A pose as it is; `is_new`: with a number of its own.
  void offer(std::vector<double> joint_rad, bool is_new = true) {
    StreamPose pose;
    pose.stream = stream;
    pose.sequence = is_new ? ++sequence_ : sequence_;
    pose.arrived = clock_();
    pose.names = motion_.config().governor.names;
    pose.joint_rad = std::move(joint_rad);
    motion_.offer(pose);
  }

  /// Idle, then a pose, then armed and under power; false if it does not come there.
  bool start(double share = 0.4) {
    if (!turnUntil(safety::GovernorState::kIdle)) return false;
    offer(share);
    motion_.request(Request::kArm);
    for (int i = 0; i < 300 && !state().is_powered; ++i)
      turn();
    return state().is_powered && state().state == safety::GovernorState::kArmed;
  }

  std::vector<double> angles() {
    std::vector<double> all;
    for (std::size_t i = 0; i < motion_.config().motors.size(); ++i)
      all.push_back(rig_->angle(i));
    return all;
  }

  devices::TimePoint now() { return clock_(); }

  bool is_streaming = true;
  std::optional<devices::TimePoint> stop_asked_at;  ///< as a signal would, also during a turn
  std::function<void(const config::HandConfig&)> before_making;  ///< a device; may refuse it
  std::uint64_t stream = 1;

 private:
  std::unique_ptr<HandRig> rig_;
  devices::Clock clock_;
  devices::Duration period_;
  Motion motion_;
  std::uint64_t sequence_ = 0;
};

}  // namespace handgraft::bridge::test
