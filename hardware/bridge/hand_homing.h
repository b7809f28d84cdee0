#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bridge/device_factory.h"
#include "hardware/safety/homing_run.h"

namespace handgraft::bridge {

/// Turns from 0 that a marked encoder is at least told to count from; at most three times that.
inline constexpr double kLeastMarkTurns = 32;

/// Finds the zeros of a hand: one motor after the other runs gently to its stop (HomingRun),
/// the others hold where they stand. Each step is made on a device of its own, whose range is
/// that of the step: before its zero is known, a motor's own range says nothing. The device's
/// own limits of the motor that runs are the step's, too: a little more current than holds it
/// back, and its speed. Once it stands, an incremental encoder is told to count from a place of
/// ours, tens of turns away, so that a restart shows (`MotorConfig::is_marked`).
///
/// Between steps, and after whatever goes wrong, all motors are off.
class HandHoming {
 public:
  enum class State { kRunning, kDone, kFailed };

  /// Nothing moves yet; the wire has to be free. Errors: BrokenContract without homing steps.
  HandHoming(config::HandConfig config, MakeDevice make_device, devices::Clock clock);
  ~HandHoming();

  /// One period. Opening and switching on a device takes its time.
  State turn();

  /// Motors off at once; by the device's own stop if `cuts`. Failed then.
  void abort(bool cuts);

  [[nodiscard]] State state() const { return state_; }

  /// Why it failed.
  [[nodiscard]] const std::string& reason() const { return reason_; }

  /// Of the device of this step, rad from a zero that is not known yet; nothing between steps.
  [[nodiscard]] const devices::DeviceState* measured() const;

  /// The config with the zeros that were found so far.
  [[nodiscard]] const config::HandConfig& config() const { return config_; }

 private:
  void beginStep();
  void advance();
  void finishStep(double zero_rad);
  void fail(std::string why);
  // The motor of this step in a range that holds the whole step.
  [[nodiscard]] config::HandConfig widened(double start_rad) const;

  config::HandConfig config_;
  MakeDevice make_device_;
  devices::Clock clock_;
  State state_ = State::kRunning;
  std::string reason_;
  std::size_t step_ = 0;
  DeviceStack stack_;
  std::optional<devices::DeviceState> measured_;
  std::optional<safety::HomingRun> run_;
  std::vector<double> targets_;
  double start_rad_ = 0;
};

}  // namespace handgraft::bridge
