#pragma once

#include <chrono>
#include <optional>

#include "hardware/safety/governor_types.h"
#include "hardware/safety/joint_limiter.h"

namespace handgraft::safety {

/// How one motor finds its zero: it turns until it is held back, there it is at `stop_rad`.
struct HomingStep {
  std::size_t motor = 0;
  int toward = 1;           ///< 1 or -1: the sign of its velocity
  double speed_rad_s = 0;   ///< positive
  double current_A = 0;     ///< held back: the current stays at least so high ...
  Milliseconds hold{200};   ///< ... for so long, and the motor stands
  double travel_rad = 0;    ///< never farther than this from where it began
  double stop_rad = 0;      ///< the motor's angle at the stop
  double back_off_rad = 0;  ///< turned back afterwards
};

/// Executes one step, a period at a time, on angles of a motor that has no zero yet. A pure
/// state machine in injected time, as the governor is; whoever runs it gives the motor power
/// and limits its current, and stops everything on an emergency stop.
///
/// The target never leaves `travel_rad` around the start, is never farther from where the motor
/// says it is than half a second's way and 0.1 rad, and what is sent is smooth: should it not
/// move, or not say so, it is not sent on. A motor that is not held back within that travel, or
/// not within twice the time that it takes, has failed: it brakes and keeps its place.
class HomingRun {
 public:
  enum class State { kSeeking, kPressing, kBackingOff, kDone, kFailed };

  /// Errors: InvalidInput for numbers that are not finite or not positive where they must be.
  HomingRun(const HomingStep& step, double period_s, double start_rad, Time now);

  /// What to send (rad) after the motor measured its angle and current; `now` must not run
  /// backwards. What is not finite fails the run.
  double tick(double position_rad, double current_A, Time now);

  [[nodiscard]] State state() const { return state_; }

  /// The device's angle where the motor's is 0; once the stop was found.
  [[nodiscard]] std::optional<double> zero() const { return zero_rad_; }

  /// So far: rad from the start, and A.
  [[nodiscard]] double farthest() const { return farthest_rad_; }

  [[nodiscard]] double largestCurrent() const { return largest_A_; }

 private:
  void seek(double position_rad, double current_A, Time now);

  HomingStep step_;
  JointLimiter limiter_;
  State state_ = State::kSeeking;
  double start_rad_;
  Time deadline_;
  Time pressing_since_{};
  double pressed_at_rad_ = 0;
  double farthest_rad_ = 0;
  double largest_A_ = 0;
  std::optional<double> zero_rad_;
};

const char* toString(HomingRun::State state);

}  // namespace handgraft::safety
