#pragma once

#include <numbers>
#include <optional>

#include "hardware/devices/can_channel.h"
#include "hardware/devices/device.h"
#include "hardware/devices/motor_scale.h"
#include "hardware/protocols/odrive_can.h"

namespace handgraft::devices {

/// One axis: turns of its encoder.
struct ODriveAxis {
  int node = 0;
  MotorScale scale{2.0 * std::numbers::pi};
  double velocity_limit_rev_s = 2.0;
  double current_limit_A = 5.0;
};

struct ODriveConfig {
  std::vector<ODriveAxis> axes;
  protocols::odrive::Firmware firmware = protocols::odrive::Firmware::k06;
  Duration reply_timeout = std::chrono::milliseconds(5);  ///< of all axes together
  int tolerated_misses = 3;  ///< answers in a row; then a current is not known any more
  /// Axes tell their state every 100 ms unless configured otherwise.
  Duration heartbeat_timeout = std::chrono::milliseconds(350);
  Duration state_timeout = std::chrono::seconds(1);  ///< for a change of state
  /// As saved on the axes: within one and a half of it an axis left alone must switch itself
  /// off.
  Duration watchdog = std::chrono::milliseconds(200);
};

/// Brushless motors behind ODrive axes on a CAN bus, in position control.
///
/// In each cycle every axis is asked for its estimates, one of them in turn for its current and
/// its temperatures (`open` asks all of them), the attended one always for its current;
/// heartbeats come by themselves. The watchdog cannot be set over CAN: `enable_watchdog` and
/// `watchdog_timeout` have to be saved on each axis. The first `arm` after each `open`, and
/// after an axis was not heard of for long enough to have restarted, proves them: it holds the
/// axes where they stand, falls silent, and goes on only if each one said that its watchdog
/// switched it off. That error, and no other, `arm` clears.
///
/// An axis latches its errors. `arm` clears no other, `reset` does. `stop` is the axes' own
/// emergency stop, which is such an error.
class ODriveHand final : public Device {
 public:
  /// `can` has to live as long as this. Errors: InvalidInput, naming axis and value.
  ODriveHand(ODriveConfig config, CanChannel& can, Clock clock);

  [[nodiscard]] std::size_t motorCount() const override { return config_.axes.size(); }

  [[nodiscard]] DeviceCounters counters() const override;

  void attend(std::size_t motor) override { attended_ = motor; }

  [[nodiscard]] std::string meaningOf(std::uint32_t code) const override;

 private:
  /// What is known of one axis.
  struct Known {
    protocols::odrive::Heartbeat heartbeat;
    TimePoint heartbeat_time;
    bool has_heartbeat = false;
    protocols::odrive::FloatPair estimates;  ///< rev, rev/s
    TimePoint estimates_time;
    bool is_answered = false;  ///< in this cycle
    bool has_estimates = false;
    int misses = 0;
    double current_A = 0.0;    ///< NaN until it is told
    int current_misses = 0;    ///< in a row
    double temperature = 0.0;  ///< degrees Celsius, the hotter one; NaN until it is told
  };

  void doOpen() override;
  void doArm() override;
  void doRead(DeviceState& state) override;
  void doWrite(std::span<const double> targets) override;
  bool doDisarm() override;
  void doStop() override;
  void doHeal() override;
  bool doRecount(std::size_t motor, double encoder_rad) override;

  // What a frame says, to the axis it is from.
  void take(const protocols::CanFrame& frame);
  // Takes frames until `is_done()` or the deadline; true if done.
  template <class Done>
  bool listen(Duration time, Done&& is_done);
  // Takes all that came by itself, so that it neither answers nor piles up.
  void drain();
  // Asks all axes for their estimates; false if one does not answer.
  bool ask();
  // Asks all axes for their currents; false if one of them has never told it.
  bool askForCurrents();
  // Asks for a state until heartbeats sent after that confirm it; false after the timeout.
  template <class Again>
  bool reach(protocols::odrive::AxisState state, Again&& again);
  void setStates(protocols::odrive::AxisState state);
  void setLimits();
  // Power on with each axis told to stay at `here`.
  void closeLoops(const std::vector<float>& here);
  void proveWatchdogs();
  [[nodiscard]] bool isWatchdogsAlone(const protocols::odrive::Heartbeat& heartbeat) const;
  [[nodiscard]] bool haveHeartbeatsSince(TimePoint time) const;
  void findFaults(TimePoint now);

  ODriveConfig config_;
  CanChannel& can_;
  Clock clock_;
  std::vector<Known> known_;
  std::size_t turn_ = 0;  // which axis is asked for its current
  std::optional<std::size_t> attended_;
  bool expects_power_ = false;
  bool is_watchdog_proved_ = false;  // of each axis, since `open` or a silence
  DeviceCounters counters_;
};

}  // namespace handgraft::devices
