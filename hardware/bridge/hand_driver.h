#pragma once

#include <chrono>
#include <span>
#include <vector>

namespace handgraft::bridge {

/// What a hand measured, one entry per joint: rad and rad/s (m and m/s if prismatic).
struct JointReading {
  std::chrono::steady_clock::time_point time;
  std::vector<double> position;
  std::vector<double> velocity;
};

/// A hand on the other end of a wire. The bridge calls it from one thread, once a period:
/// `read`, then `write` while the motors are to hold or move, or `stop` once they are not. What
/// it is sent already keeps every limit; a driver checks nothing but its own wire.
///
/// Errors: every method throws DeviceError when the device fails; the bridge then latches a
/// fault and calls `stop`.
class HandDriver {
 public:
  virtual ~HandDriver() = default;
  HandDriver() = default;
  HandDriver(const HandDriver&) = delete;
  HandDriver& operator=(const HandDriver&) = delete;

  /// Connects; motors off, nothing moves.
  virtual void open() = 0;

  /// The measured state; resizes the vectors of `reading` as needed.
  virtual void read(JointReading& reading) = 0;

  /// Motors on, towards these positions (rad or m, one per joint).
  virtual void write(std::span<const double> targets) = 0;

  /// Motors off, wherever the hand is.
  virtual void stop() = 0;
};

}  // namespace handgraft::bridge
