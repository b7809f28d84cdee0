#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bridge/device_factory.h"
#include "hardware/bridge/encoder_zero_monitor.h"
#include "hardware/bridge/hand_homing.h"
#include "hardware/bridge/motion_state.h"
#include "hardware/bridge/motor_path.h"
#include "hardware/bridge/motor_watch.h"
#include "hardware/bridge/request_ring.h"
#include "hardware/bridge/sample_path.h"
#include "hardware/bridge/timed_pose_ring.h"
#include "hardware/safety/governor.h"
#include "idl/hardware.h"

namespace handgraft::bridge {

/// A pose that a stream asks for, on its way to the governor.
struct StreamPose {
  std::uint64_t stream = 0;
  std::uint64_t sequence = 0;
  std::int64_t source_ns = 0;  ///< the sender's clock; 0: not told
  safety::Time arrived{};
  std::vector<std::string> names;
  std::vector<double> joint_rad;
};

/// One hand in motion: device, transmission and governor, one period a `turn`. Without threads
/// and with the clock that it is given.
///
/// A turn reads the device, lets the governor decide, and obeys its order. Nothing allocates,
/// locks or logs in a turn under power; switching on, resetting and homing take their time,
/// with the motors off or standing. An order that the motors' own assertion objects to is not
/// sent: the motors go off and the governor is told of a fault.
///
/// A device that is not there is tried again each second, but never one that was lost under
/// power: that takes a RESET. Opening and resetting leave the motors off.
class Motion {
 public:
  /// Told when zeros were found, in the turn that found them; and nothing when homing begins,
  /// from when on the zeros of before are void.
  using OnHomed = std::function<void(const config::HandConfig*)>;

  /// Errors: InvalidInput for what governor, transmission or driver do not accept.
  Motion(config::HandConfig config,
         MakeDevice make_device,
         devices::Clock clock,
         OnHomed on_homed = {});
  /// Switches the motors off.
  ~Motion();

  // === Between turns

  void offer(const StreamPose& pose);
  /// A sample of the stream whose pose was accepted last. While such samples come, poses of
  /// the stream wait for nothing and change nothing: its samples are the newer word.
  void offer(const TimedPose& sample);
  /// `stream` lived at `time`.
  void renew(std::uint64_t stream, safety::Time time);
  void request(Request request);
  void estop();

  // === One period

  void turn();

  /// True if the last turn did what may take long: then it is no wonder that it did.
  [[nodiscard]] bool wasSlow() const { return was_slow_; }

  /// Motors off, whatever the governor thinks. For the end.
  void switchOff();

  [[nodiscard]] const MotionState& state() const { return state_; }

  [[nodiscard]] const config::HandConfig& config() const { return config_; }

 private:
  void openIfDue(safety::Time now);
  void open();
  bool measure();
  void guide(safety::Time now);
  double permittedRate();
  void noteClamping();
  void govern(safety::Time now);
  void obey(const safety::MotorOrder& order);
  void drive(std::span<const double> joint_rad);
  void arm();
  void heal();
  void beginHoming();
  void turnHoming(safety::Time now);
  void refuse(v1::BridgeRefusal code,
              std::string_view what,
              std::string_view why,
              std::string_view detail = {});
  void accept();
  void noteFault();
  void tell(safety::Time now);
  void tellSamples(safety::Time now);

  config::HandConfig config_;
  MakeDevice make_device_;
  devices::Clock clock_;
  OnHomed on_homed_;
  safety::Governor governor_;
  MotorPath path_;
  SamplePath samples_;
  DeviceStack stack_;
  EncoderZeroMonitor zeros_;
  MotorWatch motors_;
  std::unique_ptr<HandHoming> homing_;

  bool is_open_ = false;
  bool has_measured_ = false;  // since it is open
  bool was_armed_ = false;     // in the last turn, so that the path has begun
  bool guard_failed_ = false;
  bool was_slow_ = false;
  bool is_clamped_ = false;  // the newest accepted pose
  bool is_last_refusal_a_poses_ = false;
  FixedText pose_refusal_;  // why the newest pose was refused; empty: it was accepted
  std::optional<safety::Time> next_open_;
  std::optional<safety::Time> renewed_at_;
  std::uint64_t limited_before_ = 0;
  std::size_t slow_joint_ = 0;  // that keeps samples from being followed at their speed
  devices::DeviceState measured_;
  MotionState state_;
  std::vector<std::size_t> joint_of_motor_;  // of direct drive; else empty
};

}  // namespace handgraft::bridge
